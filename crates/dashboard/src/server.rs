//! The HTTP server. It answers `GET` for these paths and nothing else.
//!
//! | path | what it is |
//! |---|---|
//! | `/` | the page |
//! | `/dashboard.css`, `/dashboard.js` | its style and its script |
//! | `/events` | server-sent events: `line` once, then every view |
//! | `/metrics` | the figures of the next view, for Prometheus |

use crate::metrics;
use crate::page::{DASHBOARD_PAGE, dashboard_script, dashboard_style};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full, StreamBody};
use hyper::body::{Bytes, Frame, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use pickline_live::LineView;
use pickline_live::transport::tls::{Stream, Tls};
use pickline_live::transport::{Access, Token, is_short_of_descriptors};
use std::convert::Infallible;
use std::net::{IpAddr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::time::Duration;
use tokio::sync::{Semaphore, watch};
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::WatchStream;

/// The newest view as the text of an event, for all browsers.
pub(crate) type Texts = watch::Sender<Bytes>;

type Body = BoxBody<Bytes, Infallible>;

/// Simultaneous connections; further ones wait to be accepted.
const MOST_CONNECTIONS: u32 = 64;
/// Browsers that can watch at a time; further ones get status 503.
const MOST_WATCHERS: usize = 32;
/// A request that is not complete after this time is dropped.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);
/// How long a request for metrics waits for a view. A working line shows one at once.
const VIEW_TIMEOUT: Duration = Duration::from_secs(2);
/// Pause after a failed accept, which means that too many files are open.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// The content security policy: nothing from other sites, no inline script or style.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; \
                      frame-ancestors 'none'";

/// The data for requests for metrics.
pub(crate) struct Scraped {
    /// The newest view of the line; `None` before the first.
    pub views: watch::Receiver<Option<Arc<LineView>>>,
    /// Set to request the next view.
    pub wanted: Arc<AtomicBool>,
    /// Name of the line's strategy.
    pub strategy: String,
}

/// What all connections share.
struct Site {
    scraped: Scraped,
    line: Bytes,
    script: Bytes,
    style: Bytes,
    /// Dropped once the last view has been shown.
    texts: Weak<Texts>,
    /// Whether only this machine can connect, because the address is a loopback one.
    is_local: bool,
    /// The token that a browser must present, if any.
    token: Option<Token>,
}

/// Serves until the views end and every browser has the last one.
pub(crate) async fn serve(
    listener: TcpListener,
    access: Access,
    line: String,
    scraped: Scraped,
    views: watch::Receiver<Option<Arc<LineView>>>,
    texts: Arc<Texts>,
) {
    let is_local = listener
        .local_addr()
        .is_ok_and(|address| address.ip().is_loopback());
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
        return;
    };
    let site = Arc::new(Site {
        scraped,
        line: event("line", &line),
        script: Bytes::from(dashboard_script()),
        style: Bytes::from(dashboard_style()),
        texts: Arc::downgrade(&texts),
        is_local,
        token: access.token,
    });
    let connections = Arc::new(Semaphore::new(MOST_CONNECTIONS as usize));
    let accepting = tokio::spawn(accept_all(
        listener,
        access.tls,
        site,
        Arc::clone(&connections),
    ));
    write_texts(views, &texts).await;
    accepting.abort();
    // A stream ends once it has sent the newest text and there is no sender left.
    drop(texts);
    let _ = connections.acquire_many(MOST_CONNECTIONS).await;
}

/// Formats every view as an event, once for all browsers.
async fn write_texts(mut views: watch::Receiver<Option<Arc<LineView>>>, texts: &Texts) {
    while views.changed().await.is_ok() {
        let view = views.borrow_and_update().clone();
        // Numbers and text always convert to JSON.
        let json = view.and_then(|view| serde_json::to_string(&*view).ok());
        if let Some(json) = json {
            texts.send_replace(event("view", &json));
        }
    }
}

fn event(name: &str, json: &str) -> Bytes {
    // The JSON has no line breaks, which would end the event.
    Bytes::from(format!("event: {name}\ndata: {json}\n\n"))
}

async fn accept_all(
    listener: tokio::net::TcpListener,
    tls: Option<Tls>,
    site: Arc<Site>,
    connections: Arc<Semaphore>,
) {
    loop {
        // The semaphore is never closed.
        let Ok(permit) = Arc::clone(&connections).acquire_owned().await else {
            return;
        };
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_RETRY_DELAY).await;
            continue;
        };
        if is_short_of_descriptors(&stream) {
            // The journal needs descriptors too.
            drop(stream);
            tokio::time::sleep(ACCEPT_RETRY_DELAY).await;
            continue;
        }
        let (site, tls) = (Arc::clone(&site), tls.clone());
        tokio::spawn(async move {
            let stream: Stream = match tls {
                None => Box::new(stream),
                Some(tls) => {
                    match tokio::time::timeout(REQUEST_TIMEOUT, tls.accept(stream)).await {
                        Ok(Ok(stream)) => stream,
                        // TLS itself tells a browser that its certificate is not trusted.
                        Ok(Err(_)) | Err(_) => return,
                    }
                }
            };
            let answer = service_fn(|request| {
                let site = Arc::clone(&site);
                async move { Ok::<_, Infallible>(site.answer(&request).await) }
            });
            // Ignore a browser that has disconnected.
            let _ = http1::Builder::new()
                // One request per connection, so that no connection stays idle.
                .keep_alive(false)
                .timer(TokioTimer::new())
                .header_read_timeout(REQUEST_TIMEOUT)
                .serve_connection(TokioIo::new(stream), answer)
                .await;
            drop(permit);
        });
    }
}

impl Site {
    async fn answer(&self, request: &Request<Incoming>) -> Response<Body> {
        if request.method() != Method::GET {
            let mut response = words(StatusCode::METHOD_NOT_ALLOWED, "this page is read-only\n");
            let headers = response.headers_mut();
            headers.insert(header::ALLOW, HeaderValue::from_static("GET"));
            return response;
        }
        let host = request.headers().get(header::HOST);
        if self.is_local && !host.is_some_and(names_this_machine) {
            // DNS rebinding: another site's name that resolves to this machine.
            return words(
                StatusCode::FORBIDDEN,
                "open this page by its IP address or as \
                                                 localhost\n",
            );
        }
        if let Some(token) = &self.token
            && !shows(request.headers().get(header::AUTHORIZATION), token)
        {
            let mut response = words(
                StatusCode::UNAUTHORIZED,
                "the password is the token that the line was started with\n",
            );
            let asks = HeaderValue::from_static("Basic realm=\"pickline\", charset=\"UTF-8\"");
            let headers = response.headers_mut();
            headers.insert(header::WWW_AUTHENTICATE, asks);
            return response;
        }
        match request.uri().path() {
            "/" => whole(
                "text/html; charset=utf-8",
                Bytes::from_static(DASHBOARD_PAGE.as_bytes()),
            ),
            "/dashboard.css" => whole("text/css; charset=utf-8", self.style.clone()),
            "/dashboard.js" => whole("text/javascript; charset=utf-8", self.script.clone()),
            "/events" => self.events(),
            "/metrics" => self.metrics().await,
            "/favicon.ico" => words(StatusCode::NO_CONTENT, ""),
            _ => words(
                StatusCode::NOT_FOUND,
                "not found: there is one page, at /, and /metrics\n",
            ),
        }
    }

    /// The current figures. If the line shows nothing, the answer is an error, because old figures
    /// would hide that it has stalled.
    async fn metrics(&self) -> Response<Body> {
        let mut views = self.scraped.views.clone();
        views.mark_unchanged();
        self.scraped.wanted.store(true, Ordering::Relaxed);
        // When the line ends, its last view is used.
        let waited = tokio::time::timeout(VIEW_TIMEOUT, views.changed()).await;
        let view = views.borrow().clone();
        match view.filter(|_| waited.is_ok()) {
            Some(view) => whole(
                "text/plain; version=0.0.4; charset=utf-8",
                Bytes::from(metrics(&view, &self.scraped.strategy)),
            ),
            None => words(
                StatusCode::SERVICE_UNAVAILABLE,
                "the line has sent no figures for 2 s\n",
            ),
        }
    }

    fn events(&self) -> Response<Body> {
        let texts = self.texts.upgrade();
        let Some(texts) = texts.filter(|texts| texts.receiver_count() < MOST_WATCHERS) else {
            return words(
                StatusCode::SERVICE_UNAVAILABLE,
                "too many browsers are watching\n",
            );
        };
        let line = tokio_stream::once(self.line.clone());
        // A view that is not sent by the time the next one comes is skipped.
        let views = WatchStream::new(texts.subscribe()).filter(|text| !text.is_empty());
        let frames = line.chain(views).map(|text| Ok(Frame::data(text)));
        response(
            StatusCode::OK,
            "text/event-stream",
            BodyExt::boxed(StreamBody::new(frames)),
        )
    }
}

/// Whether a request presents the token: as a bearer token (RFC 6750), or as the password of any
/// user (RFC 7617), for which browsers prompt.
fn shows(authorization: Option<&HeaderValue>, token: &Token) -> bool {
    let Some((scheme, given)) = authorization
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.split_once(' '))
    else {
        return false;
    };
    let given = given.trim();
    if scheme.eq_ignore_ascii_case("bearer") {
        return token.is(given);
    }
    let Some(text) = BASE64_STANDARD
        .decode(given)
        .ok()
        .and_then(|bytes| String::from_utf8(bytes).ok())
    else {
        return false;
    };
    let password = text.split_once(':').map(|(_, password)| password);
    scheme.eq_ignore_ascii_case("basic") && password.is_some_and(|given| token.is(given))
}

/// Whether a `Host` is an IP address or `localhost`, which no page of another site can have.
fn names_this_machine(host: &HeaderValue) -> bool {
    let Ok(host) = host.to_str() else {
        return false;
    };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost") || bare.parse::<IpAddr>().is_ok()
}

fn words(status: StatusCode, text: &'static str) -> Response<Body> {
    let body = Full::new(Bytes::from_static(text.as_bytes())).boxed();
    response(status, "text/plain; charset=utf-8", body)
}

fn whole(kind: &'static str, content: Bytes) -> Response<Body> {
    response(StatusCode::OK, kind, Full::new(content).boxed())
}

fn response(status: StatusCode, kind: &'static str, body: Body) -> Response<Body> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    for (name, value) in [
        (header::CONTENT_TYPE, kind),
        (header::CACHE_CONTROL, "no-store"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        response
            .headers_mut()
            .insert(name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_token_is_taken_as_a_bearer_or_as_a_password() {
        let token = Token::new("0123456789abcdef");
        let shown = |text: &str| shows(HeaderValue::from_str(text).ok().as_ref(), &token);
        let basic = |text: &str| format!("Basic {}", BASE64_STANDARD.encode(text));
        assert!(shown("Bearer 0123456789abcdef"));
        assert!(shown("bearer  0123456789abcdef"));
        assert!(shown(&basic("anybody:0123456789abcdef")));
        assert!(shown(&basic(":0123456789abcdef")));
        for wrong in [
            "",
            "0123456789abcdef",
            "Bearer 0123456789abcdeg",
            "Bearer ",
            "Digest 0123456789abcdef",
            "Basic 0123456789abcdef",
            &basic("0123456789abcdef"),
            &basic("0123456789abcdef:"),
        ] {
            assert!(!shown(wrong), "{wrong}");
        }
        assert!(!shows(None, &token));
    }

    #[test]
    fn hosts_of_other_sites_are_told_apart() {
        for host in [
            "127.0.0.1:8090",
            "localhost",
            "LOCALHOST:1",
            "[::1]:8090",
            "[::1]",
        ] {
            assert!(
                names_this_machine(&HeaderValue::from_static(host)),
                "{host}"
            );
        }
        for host in [
            "",
            "evil.example",
            "evil.example:8090",
            "127.0.0.1.evil.example:80",
        ] {
            assert!(
                !names_this_machine(&HeaderValue::from_static(host)),
                "{host}"
            );
        }
    }
}
