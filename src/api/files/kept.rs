//! What a file is apart from its content: who may do what with it, whose it is, what it was when it was read.

use std::fs::{self, Metadata};
use std::io;
use std::path::Path;

use sha2::{Digest, Sha256};

/// What a file held when it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Was {
    length: u64,
    hash: [u8; 32],
}

impl Was {
    /// A file of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self { length: bytes.len() as u64, hash: Sha256::digest(bytes).into() }
    }

    /// Whether a file still holds the same.
    pub(super) fn is_still(&self, file: &Path) -> bool {
        let same_length = fs::metadata(file).is_ok_and(|about| about.len() == self.length);
        same_length && fs::read(file).is_ok_and(|bytes| Self::of(&bytes) == *self)
    }
}

/// Which file stands at a place, and when it was changed last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    /// Number of the file on its disk; 0 where the system tells none.
    pub(super) file: u64,
    pub(super) length: u64,
    /// Nanoseconds since 1970.
    pub(super) changed: u64,
}

impl Stamp {
    pub(super) fn of(about: &Metadata) -> Self {
        #[cfg(unix)]
        let file = std::os::unix::fs::MetadataExt::ino(about);
        #[cfg(not(unix))]
        let file = 0;
        let since = about.modified().ok().and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
        let changed = since.map_or(0, |since| since.as_nanos() as u64);
        Self { file, length: about.len(), changed }
    }

    /// Of what stands at a place; a link stands for itself.
    pub(super) fn at(place: &Path) -> Option<Self> {
        fs::symlink_metadata(place).ok().map(|about| Self::of(&about))
    }
}

/// Whether a file may be written. Root may write all: so the file itself is asked, too.
pub(super) fn is_writable(file: &Path, about: &Metadata) -> bool {
    #[cfg(unix)]
    let allowed = {
        use rustix::fs::{Access, AtFlags, CWD, accessat};
        // Not every system can answer for the effective user.
        accessat(CWD, file, Access::WRITE_OK, AtFlags::EACCESS) != Err(rustix::io::Errno::ACCESS)
    };
    #[cfg(not(unix))]
    let allowed = file.exists();
    allowed && !about.permissions().readonly()
}

/// Whether a file has other names.
pub(super) fn has_other_names(about: &Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::MetadataExt::nlink(about) > 1;
    #[cfg(not(unix))]
    return {
        let _ = about;
        false
    };
}

/// Gives a draft the owner, the rights and the extended attributes of the file that it replaces.
///
/// # Errors
///
/// Where one of them cannot be given: then the content is to be written into the file that is there.
pub(super) fn keep(draft: &Path, file: &Path, about: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, chown};
        let own = fs::metadata(draft)?;
        if (own.uid(), own.gid()) != (about.uid(), about.gid()) {
            chown(draft, Some(about.uid()), Some(about.gid()))?;
        }
    }
    // After the owner, with whom the system takes rights away.
    fs::set_permissions(draft, about.permissions())?;
    keep_attributes(draft, file)
}

#[cfg(target_os = "linux")]
fn keep_attributes(draft: &Path, file: &Path) -> io::Result<()> {
    use rustix::fs::{XattrFlags, getxattr, getxattr_query, removexattr, setxattr};
    let (wanted, own) = (attributes(file)?, attributes(draft)?);
    for name in own.iter().filter(|name| !wanted.contains(name)) {
        removexattr(draft, name.as_slice())?;
    }
    for name in &wanted {
        let name = name.as_slice();
        let mut value = vec![0; getxattr_query(file, name)?];
        let length = getxattr(file, name, &mut value[..])?;
        value.truncate(length);
        let mut own = vec![0; length];
        if getxattr(draft, name, &mut own[..]) != Ok(length) || own != value {
            setxattr(draft, name, &value, XattrFlags::empty())?;
        }
    }
    Ok(())
}

/// Names of a file's extended attributes, access lists among them.
#[cfg(target_os = "linux")]
fn attributes(file: &Path) -> io::Result<Vec<Vec<u8>>> {
    use rustix::fs::{listxattr, listxattr_query};
    use rustix::io::Errno;
    let mut names = match listxattr_query(file) {
        Err(Errno::NOTSUP) => return Ok(Vec::new()),
        length => vec![0u8; length?],
    };
    let length = listxattr(file, &mut names[..])?;
    names.truncate(length);
    Ok(names.split(|byte| *byte == 0).filter(|name| !name.is_empty()).map(<[u8]>::to_vec).collect())
}

#[cfg(not(target_os = "linux"))]
fn keep_attributes(_: &Path, _: &Path) -> io::Result<()> {
    Ok(())
}
