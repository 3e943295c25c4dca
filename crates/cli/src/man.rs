//! `pickline man`: the manual pages, generated from the arguments.

use super::session::Session;
use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use pickline::error::{Error, Result, known_names, shown};

/// One manual page.
pub(crate) struct Page {
    /// Its name, such as `pickline-run`.
    pub name: String,
    /// Its troff source.
    pub text: Vec<u8>,
}

/// The pages of all commands, starting with the program's own.
pub(crate) fn pages() -> Vec<Page> {
    let mut root = super::command().disable_help_subcommand(true);
    root.build();
    let mut pages = Vec::new();
    collect(&root, &mut pages);
    pages
}

fn collect(command: &Command, pages: &mut Vec<Page>) {
    let name = command
        .get_display_name()
        .unwrap_or_else(|| command.get_name());
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = write(command, &mut text);
    pages.push(Page {
        name: name.to_owned(),
        text,
    });
    for part in command.get_subcommands() {
        collect(part, pages);
    }
}

fn write(command: &Command, page: &mut Vec<u8>) -> std::io::Result<()> {
    let man = Man::new(command.clone()).source(concat!("pickline ", env!("CARGO_PKG_VERSION")));
    man.render_title(page)?;
    man.render_name_section(page)?;
    man.render_synopsis_section(page)?;
    man.render_description_section(page)?;
    man.render_options_section(page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(page)?;
    }
    let more = command.get_after_long_help().or(command.get_after_help());
    let more = more.map(ToString::to_string).unwrap_or_default();
    // Keep the lines as they are: commands must not be broken.
    let (title, lines) = match more.strip_prefix("Example") {
        Some(rest) => (
            "EXAMPLES",
            rest.trim_start_matches('s')
                .trim_start_matches(':')
                .trim_start_matches('\n'),
        ),
        None => ("NOTES", &*more),
    };
    if !lines.is_empty() {
        let mut roff = Roff::new();
        roff.control("SH", [title]).control("nf", []);
        for line in lines.lines() {
            roff.text([roman(line)]);
        }
        roff.control("fi", []);
        roff.to_writer(page)?;
    }
    Ok(())
}

/// Prints the page of a command.
pub(crate) fn run(words: &[String], session: &Session) -> Result<()> {
    let name = [&["pickline".to_owned()], words].concat().join("-");
    let pages = pages();
    match pages.iter().find(|page| page.name == name) {
        Some(page) => session.print(&page.text),
        None => {
            let known = pages
                .iter()
                .filter_map(|page| page.name.strip_prefix("pickline-"));
            let known: Vec<String> = known.map(|name| name.replace('-', " ")).collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let given = shown(&words.join(" "));
            Err(Error::usage(
                "man",
                format!("there is no command `{given}`"),
                known_names(&given, &known),
            ))
        }
    }
}
