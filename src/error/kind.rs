//! The kinds of failures, and which failures of the operating system are which.

use std::io;

/// The sort of a failure, by which a program chooses its exit code or its answer.
///
/// Who has to change something decides the kind, not what the value is: a belt speed that the
/// station forbids is [`Usage`](Self::Usage) if an option sets it, and [`Input`](Self::Input) if
/// it is in the station file. An error of kind `Usage` names the setting as its place; one of kind
/// `Input` names the file with line and key, or the part of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The caller asked for something that is not possible: an option, argument, flag or name that
    /// is not allowed, a setting that contradicts another or does not fit the station or the
    /// patterns, or one that does not work here, such as an address in use or a broker that refuses
    /// the user. The caller has to ask for something else.
    Usage,
    /// Data is not what the model or the format allows: the content of a file, of a message of a
    /// peer or of a checkpoint, or a station, pattern or game that is built from values. The data
    /// has to be corrected.
    Input,
    /// A path cannot be used as given, whoever gave it: it does not exist, already exists, is a
    /// folder or a device, is in use, or may not be accessed or may be accessed by too many.
    Path,
    /// Reading or writing failed although the path is usable: a full disk, a broken device.
    Io,
    /// The operating system could not provide something: memory, a thread, another open file.
    Resources,
    /// A strategy chose an action that the model forbids.
    IllegalAction,
    /// A check found that a result violates what it promises.
    Refuted,
    /// The user stopped the work before there was a result to report.
    Interrupted,
    /// Only a shard of the work was to be done, and it is done (see `shards`).
    Sharded,
    /// A defect of this library.
    Internal,
}

impl ErrorKind {
    /// The kind of a failure of the operating system to read or write a path: `Path` where another
    /// path, or other rights to it, would help; `Resources` where too much is in use. Everything
    /// else is `Io`: a full disk, a device that fails.
    pub(super) fn of_file(source: &io::Error) -> Self {
        use io::ErrorKind as System;
        match source.kind() {
            System::NotFound
            | System::PermissionDenied
            | System::AlreadyExists
            | System::NotADirectory
            | System::IsADirectory
            | System::DirectoryNotEmpty
            | System::ReadOnlyFilesystem
            | System::InvalidFilename
            | System::InvalidInput
            | System::InvalidData
            | System::ExecutableFileBusy
            | System::ResourceBusy
            | System::NotSeekable
            | System::Unsupported => Self::Path,
            System::OutOfMemory => Self::Resources,
            _ if is_out_of_files(source) => Self::Resources,
            _ => Self::Io,
        }
    }
}

/// Whether the process or the whole system has too many files open. The standard library has no
/// kind for this, only the code of the system.
pub(super) fn is_out_of_files(source: &io::Error) -> bool {
    let codes: &[i32] = if cfg!(windows) {
        // ERROR_TOO_MANY_OPEN_FILES
        &[4]
    } else {
        // ENFILE and EMFILE, the same on Linux, macOS and the BSDs
        &[23, 24]
    };
    source
        .raw_os_error()
        .is_some_and(|code| codes.contains(&code))
}
