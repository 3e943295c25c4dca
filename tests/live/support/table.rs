//! Tables that tests print, and that docs/live.md shows.

/// A table in Markdown.
pub struct Table(String);

impl Table {
    pub fn new(heads: &[&str]) -> Self {
        let rule = "---|".repeat(heads.len());
        Self(format!("| {} |\n|{rule}\n", heads.join(" | ")))
    }

    pub fn row(&mut self, cells: &[String]) {
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }

    /// Prints it; docs/live.md shows the same.
    pub fn is_in_the_docs(&self) {
        println!("{}", self.0);
        let docs = include_str!("../../../docs/live.md");
        assert!(docs.contains(&self.0), "docs/live.md shows another table");
    }
}
