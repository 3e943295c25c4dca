//! The file formats in which programs write boxes and tracks, each converted to the same rows.

mod coco;
mod fields;
mod format;
mod fractions;
mod labels;
mod lines;
mod mot;
mod recognise;
mod table;

pub use format::Format;
pub(super) use lines::{FileLine, FileLines, FileRow};
pub(crate) use recognise::recognised;

use super::options::ImportOptions;
use crate::error::{Error, Result};
use fractions::scale_shares;
use recognise::{recognise, unread};
use std::path::Path;

/// A file, or a folder with one file per frame, as read from disk.
#[derive(Debug)]
pub enum Recording {
    /// The text of a file.
    Text(String),
    /// Frame number, file name and text of every file in a folder, in order of frames.
    Folder(Vec<(u32, String, String)>),
}

impl Recording {
    /// Reads a file or a folder of Ultralytics labels.
    ///
    /// # Errors
    /// If something cannot be read, or a folder contains no text file or no frame numbers in the
    /// file names.
    pub fn load(path: &Path) -> Result<Self> {
        if path.is_dir() {
            return labels::load(path).map(Self::Folder);
        }
        crate::files::read_text(path).map(Self::Text)
    }
}

/// Reads the lines of `recording`; messages call it `name`.
///
/// # Errors
/// If the meaning of the numbers is uncertain; the error says why.
pub(super) fn read(
    recording: &Recording,
    name: &str,
    options: &ImportOptions,
) -> Result<FileLines> {
    let text = match recording {
        Recording::Folder(files) => return labels::read(files, name, options),
        Recording::Text(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
    };
    let mut lines = match options.format.unwrap_or_else(|| recognise(text)) {
        Format::Mot => {
            if let Some((form, cure)) = unread(text) {
                let problem = format!("the file contains {form}, which is not supported");
                return Err(Error::input(name, problem, cure));
            }
            mot::read(text, name, options)?
        }
        Format::Table => table::read(text, name, options)?,
        Format::Yolo => return labels::read_yolo(text, name, options),
        Format::Coco => coco::read(text, name, options)?,
        Format::Ultralytics => return Err(labels::without_frames(name)),
    };
    scale_shares(&mut lines, name, options)?;
    Ok(lines)
}
