//! Files that appear at their path when they are whole.

use std::io;
use std::path::Path;

use tempfile::NamedTempFile;

/// A temporary file beside `output`, with the permissions that any new file gets, to be persisted there.
pub(crate) fn new_file_for(output: &Path) -> io::Result<NamedTempFile> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder.unwrap_or(Path::new(".")))
}
