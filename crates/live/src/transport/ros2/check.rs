//! Checks of settings that cannot work, before anything is started.

use super::Ros2Settings;
use pickline::error::{Error, Result, shown};
use std::net::IpAddr;

/// Checks the names and networks.
///
/// # Errors
/// The namespace is not valid in ROS, or this machine is not in a given network.
pub(crate) fn check(settings: &Ros2Settings) -> Result<()> {
    if let Some(problem) = wrong_namespace(&settings.namespace) {
        let problem = format!("`{}` {problem}", shown(&settings.namespace));
        let cure = "give names of letters, digits and single underscores, each beginning with a \
                    letter, separated by slashes: for example /plant/line1";
        return Err(Error::usage("'ros2_namespace'", problem, cure));
    }
    // The interfaces as DDS sees them; DDS would silently ignore others.
    let interfaces = netdev::get_interfaces();
    let here = interfaces.iter().flat_map(|interface| &interface.ipv4);
    let here: Vec<IpAddr> = here.map(|network| IpAddr::V4(network.addr())).collect();
    match settings.networks.iter().find(|ip| !here.contains(ip)) {
        None => Ok(()),
        Some(stranger) => {
            let problem = if stranger.is_ipv6() {
                format!("{stranger} is an IPv6 address; DDS uses IPv4 here")
            } else {
                format!("{stranger} is not an address of this machine")
            };
            let known: Vec<String> = here.iter().map(IpAddr::to_string).collect();
            let cure = format!("give one of {}", known.join(", "));
            Err(Error::usage("'ros2_network'", problem, cure))
        }
    }
}

/// The problem with a namespace, which begins with a slash; none if it is valid.
fn wrong_namespace(namespace: &str) -> Option<String> {
    let names = namespace.strip_prefix('/').unwrap_or(namespace);
    if names.is_empty() {
        // All topics are at the root.
        return None;
    }
    for name in names.split('/') {
        let mut characters = name.chars();
        let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
        let bad = name.chars().find(|c| !is_letter(*c) && !c.is_ascii_digit());
        if let Some(bad) = bad {
            return Some(format!("contains `{}`", shown(&bad.to_string())));
        }
        match characters.next() {
            None => return Some("has an extra slash".to_owned()),
            Some(first) if !is_letter(first) => {
                return Some(format!("has a name that begins with `{first}`"));
            }
            Some(_) if name.contains("__") => return Some("contains `__`".to_owned()),
            Some(_) => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces() {
        for good in ["/", "/line1", "/plant/line_1", "/_a"] {
            assert_eq!(wrong_namespace(good), None, "{good}");
        }
        for (bad, word) in [
            ("/a-b", "contains `-`"),
            ("/a b", "contains ` `"),
            ("/caf\u{e9}", "contains `\u{e9}`"),
            ("/a\nb", "contains `\\n`"),
            ("/line/", "an extra slash"),
            ("/a//b", "an extra slash"),
            ("/1st", "begins with `1`"),
            ("/a__b", "contains `__`"),
        ] {
            let problem = wrong_namespace(bad).unwrap();
            assert!(problem.contains(word), "{bad}: {problem}");
        }
    }
}
