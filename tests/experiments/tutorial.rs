//! The commands of `docs/sorting.md` run, and print what the page shows.

use crate::common::pickline_in;
use std::path::Path;

/// A block of the page that is set apart, and the line of text above it.
struct Block<'p> {
    above: &'p str,
    lines: Vec<&'p str>,
}

/// The blocks of the page. A command begins another one, a blank line does not.
fn blocks(page: &str) -> Vec<Block<'_>> {
    let (mut blocks, mut above) = (Vec::<Block>::new(), "");
    let mut is_open = false;
    for line in page.lines() {
        match line.strip_prefix("    ") {
            Some(text) if is_open && !text.starts_with("$ ") => {
                blocks.last_mut().unwrap().lines.push(text);
            }
            Some(text) => {
                let lines = vec![text];
                blocks.push(Block { above, lines });
                is_open = true;
            }
            None if line.is_empty() => {}
            None => (above, is_open) = (line, false),
        }
    }
    blocks
}

/// The name of the file whose content the text announces: what is quoted last.
fn file_of(above: &str) -> &str {
    above.split('`').rev().nth(1).unwrap()
}

#[test]
fn the_page_on_sorting_shows_what_its_commands_print() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let page = std::fs::read_to_string(root.join("docs/sorting.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (mut commands, mut files, mut shown) = (0, 0, 0);
    for block in blocks(&page) {
        let Some(command) = block.lines[0].strip_prefix("$ pickline ") else {
            let content = block.lines.join("\n") + "\n";
            std::fs::write(folder.path().join(file_of(block.above)), content).unwrap();
            files += 1;
            continue;
        };
        let arguments: Vec<&str> = command.split_whitespace().collect();
        let output = pickline_in(folder.path(), &arguments);
        assert!(output.status.success(), "{command}: {output:?}");
        let printed = String::from_utf8(output.stdout).unwrap();
        let mut printed = printed.lines();
        for line in &block.lines[1..] {
            assert!(
                printed.any(|other| other == *line),
                "{command} does not print, in this order: {line}"
            );
            shown += 1;
        }
        commands += 1;
    }
    assert_eq!((commands, files), (9, 2));
    assert!(shown > 30, "{shown}");
    for picture in ["delta.svg", "sorting.svg", "waste.html"] {
        assert!(folder.path().join(picture).is_file(), "{picture}");
    }
}
