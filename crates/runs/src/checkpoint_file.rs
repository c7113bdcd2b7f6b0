//! The checkpoint file: a header that identifies it and detects damage, and a body of encoded
//! values.
//!
//! | bytes | content |
//! | --- | --- |
//! | 0 to 15 | `carom checkpoint` |
//! | 16 to 19 | version of the format, [`FORMAT`] |
//! | 20 to 27 | length of the body |
//! | 28 to 31 | CRC-32 (IEEE 802.3) of the bytes 0 to 27 and the body |
//! | from 32 | the body: values in postcard's encoding, which keeps every bit of an `f64` |
//!
//! Numbers of the header are little-endian. [`crate::resumable`] defines the content of the body.
//! The file is written under another name, flushed to disk, and renamed, so a complete one always
//! exists.

use std::{
    fs,
    io::{self, Read as _},
    path::Path,
};

use anyhow::Result;
use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;

use crate::whole_file::write_lasting;

/// Version of the format. Increment it with every change of the content: of the engine's
/// checkpoint, of an observer, or of the data that a command stores.
pub const FORMAT: u32 = 30;

const MAGIC: [u8; 16] = *b"carom checkpoint";

const HEADER: usize = 32;

/// Reasons why a checkpoint file is unusable.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    /// Its first bytes are not those of a checkpoint.
    #[error("it is not a checkpoint of carom")]
    Foreign,
    /// A later program wrote it.
    #[error(
        "it was written by a newer program: its format is {found}, this program reads {FORMAT}"
    )]
    Newer {
        /// Version of its format.
        found: u32,
    },
    /// An earlier program wrote it.
    #[error(
        "it was written by an older program: its format is {found}, this program reads {FORMAT}"
    )]
    Older {
        /// Version of its format.
        found: u32,
    },
    /// It is truncated.
    #[error("it is truncated: it has {found} of {expected} bytes")]
    Truncated {
        /// Bytes present.
        found: u64,
        /// Bytes expected.
        expected: u64,
    },
    /// It has been modified since it was written.
    #[error("it is damaged: its checksum does not match")]
    Damaged,
    /// The checksum matches, but the content has another type.
    #[error("its content does not match this command: {0}")]
    Content(#[from] postcard::Error),
}

/// The values of a file, taken in the order in which they were written.
#[derive(Debug)]
pub struct CheckpointBody {
    bytes: Vec<u8>,
    taken: usize,
}

impl CheckpointBody {
    /// Reads a file and verifies that it is complete.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let bytes = fs::read(path)?;
        let known = MAGIC.len().min(bytes.len());
        if bytes.is_empty() || bytes[..known] != MAGIC[..known] {
            return Err(FileError::Foreign);
        }
        let found = bytes.len() as u64;
        let Some((header, body)) = bytes.split_first_chunk::<HEADER>() else {
            return Err(FileError::Truncated {
                found,
                expected: HEADER as u64,
            });
        };
        let (described, checksum) = (
            &header[..28],
            u32::from_le_bytes([28, 29, 30, 31].map(|at| header[at])),
        );
        let format = u32::from_le_bytes([16, 17, 18, 19].map(|at| header[at]));
        match format {
            FORMAT => {}
            found if found > FORMAT => return Err(FileError::Newer { found }),
            found => return Err(FileError::Older { found }),
        }
        let length = u64::from_le_bytes([20, 21, 22, 23, 24, 25, 26, 27].map(|at| header[at]));
        let expected = length.saturating_add(HEADER as u64);
        if found < expected {
            return Err(FileError::Truncated { found, expected });
        }
        if checksum_of(&[described, body]) != checksum || found > expected {
            return Err(FileError::Damaged);
        }
        Ok(Self {
            bytes,
            taken: HEADER,
        })
    }

    /// Decodes the next value.
    ///
    /// # Errors
    /// [`FileError::Content`] if the next value has another type.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T, FileError> {
        let (value, rest) = postcard::take_from_bytes(self.rest())?;
        self.taken = self.bytes.len() - rest.len();
        Ok(value)
    }

    /// The bytes not yet taken.
    pub fn rest(&self) -> &[u8] {
        &self.bytes[self.taken..]
    }
}

/// Encodes one value for a body.
///
/// # Errors
/// [`FileError::Content`] if it cannot be encoded.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, FileError> {
    Ok(postcard::to_stdvec(value)?)
}

/// Decodes one value from [`encode`].
///
/// # Errors
/// [`FileError::Content`] if it has another type.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, FileError> {
    Ok(postcard::from_bytes(bytes)?)
}

/// Whether a file begins like one that [`write()`] has written.
pub fn is_one(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    fs::File::open(path)
        .and_then(|mut file| file.read_exact(&mut magic))
        .is_ok()
        && magic == MAGIC
}

/// Writes a file of encoded values.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, values: &[&[u8]]) -> Result<()> {
    let header = header_of(values);
    let pieces: Vec<&[u8]> = std::iter::once(&header[..])
        .chain(values.iter().copied())
        .collect();
    write_lasting(path, &pieces)
}

/// The bytes of a file of encoded values.
pub fn bytes_of(values: &[&[u8]]) -> Vec<u8> {
    let mut bytes = header_of(values);
    bytes.extend(values.iter().copied().flatten());
    bytes
}

/// What a file of encoded values begins with.
fn header_of(values: &[&[u8]]) -> Vec<u8> {
    let length: u64 = values.iter().map(|value| value.len() as u64).sum();
    let mut header = Vec::with_capacity(HEADER);
    header.extend(MAGIC);
    header.extend(FORMAT.to_le_bytes());
    header.extend(length.to_le_bytes());
    let pieces: Vec<&[u8]> = std::iter::once(&header[..])
        .chain(values.iter().copied())
        .collect();
    let checksum = checksum_of(&pieces);
    header.extend(checksum.to_le_bytes());
    header
}

fn checksum_of(pieces: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for piece in pieces {
        hasher.update(piece);
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Message about a file of a text and some numbers after the change `spoil`.
    fn refusal(spoil: impl FnOnce(&mut Vec<u8>)) -> String {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("checkpoint");
        write(
            &path,
            &[
                &encode(&"text").unwrap(),
                &encode(&[0.1, -0.0, f64::MIN_POSITIVE]).unwrap(),
            ],
        )
        .unwrap();
        let mut bytes = fs::read(&path).unwrap();
        spoil(&mut bytes);
        fs::write(&path, bytes).unwrap();
        CheckpointBody::read(&path)
            .map(|_| ())
            .map_or_else(|error| error.to_string(), |()| "sound".to_owned())
    }

    #[test]
    fn values_are_read_back_in_order_and_to_the_bit() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("checkpoint");
        let numbers = [0.1 + 0.2, -0.0, 5e-324, f64::MAX];
        write(
            &path,
            &[&encode(&"text").unwrap(), &encode(&numbers).unwrap()],
        )
        .unwrap();
        let mut body = CheckpointBody::read(&path).unwrap();
        assert_eq!(body.take::<String>().unwrap(), "text");
        assert_eq!(
            body.take::<[f64; 4]>().unwrap().map(f64::to_bits),
            numbers.map(f64::to_bits)
        );
        assert!(body.rest().is_empty());
        assert!(body.take::<u8>().is_err(), "nothing is left");
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        assert_eq!(refusal(|_| ()), "sound");
        assert!(refusal(Vec::clear).contains("not a checkpoint"));
        let whole = HEADER + 5 + 24;
        for length in 1..whole {
            let message = refusal(|bytes| bytes.truncate(length));
            assert!(message.contains("truncated"), "{length}: {message}");
        }
    }

    #[test]
    fn a_change_of_any_byte_is_detected() {
        for place in 0..HEADER + 5 + 24 {
            let message = refusal(|bytes| bytes[place] ^= 1 << (place % 8));
            let expected: &[&str] = match place {
                0..16 => &["not a checkpoint"],
                16..20 => &["newer", "older"],
                20..28 => &["truncated", "damaged"],
                _ => &["damaged"],
            };
            assert!(
                expected.iter().any(|words| message.contains(words)),
                "{place}: {message}"
            );
        }
        assert!(refusal(|bytes| bytes.push(0)).contains("damaged"));
    }

    #[test]
    fn other_formats_and_other_files_are_refused_by_name() {
        let newer = format!("newer program: its format is {}", FORMAT + 1);
        let older = format!("older program: its format is {}", FORMAT - 1);
        assert!(refusal(|bytes| bytes[16] += 1).contains(&newer));
        assert!(refusal(|bytes| bytes[16] -= 1).contains(&older));
        assert!(
            refusal(|bytes| *bytes = b"time,energy\n0.0,1.0\n".to_vec())
                .contains("not a checkpoint")
        );
        assert!(
            CheckpointBody::read(Path::new("no/such/file"))
                .unwrap_err()
                .to_string()
                .contains("cannot be read")
        );
    }
}
