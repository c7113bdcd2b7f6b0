//! The GSD 2.0 file layer: named arrays, called chunks, in numbered frames.
//!
//! A file is a header of 256 bytes, the chunks, the index with one entry of 32 bytes for each chunk
//! (ordered by frame, then by name), and the list of names (<https://gsd.readthedocs.io>, "File
//! layer"). All numbers are little-endian.

use std::io::{self, Seek, SeekFrom, Write};

/// The first number of every file.
const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;

/// Version of the layer, 2.0.
const LAYER: u32 = 2 << 16;

/// Length of the header (bytes).
const HEADER: u64 = 256;

/// Unit in which the length of the list of names is counted (bytes).
const NAME: usize = 64;

/// An array of one of the types of GSD.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Data {
    U8(Vec<u8>),
    /// Text, as 8-bit integers.
    I8(Vec<u8>),
    U32(Vec<u32>),
    U64(Vec<u64>),
    I32(Vec<i32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl Data {
    fn code(&self) -> u8 {
        match self {
            Self::U8(_) => 1,
            Self::U32(_) => 3,
            Self::U64(_) => 4,
            Self::I8(_) => 5,
            Self::I32(_) => 7,
            Self::F32(_) => 9,
            Self::F64(_) => 10,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::U8(values) | Self::I8(values) => values.len(),
            Self::U32(values) => values.len(),
            Self::U64(values) => values.len(),
            Self::I32(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    /// Writes the numbers and returns the number of bytes.
    fn write(&self, out: &mut impl Write) -> io::Result<u64> {
        fn all<const N: usize>(
            out: &mut impl Write,
            values: impl Iterator<Item = [u8; N]>,
        ) -> io::Result<u64> {
            let mut length = 0;
            for bytes in values {
                out.write_all(&bytes)?;
                length += N as u64;
            }
            Ok(length)
        }
        match self {
            Self::U8(values) | Self::I8(values) => {
                all(out, values.iter().map(|value| value.to_le_bytes()))
            }
            Self::U32(values) => all(out, values.iter().map(|value| value.to_le_bytes())),
            Self::U64(values) => all(out, values.iter().map(|value| value.to_le_bytes())),
            Self::I32(values) => all(out, values.iter().map(|value| value.to_le_bytes())),
            Self::F32(values) => all(out, values.iter().map(|value| value.to_le_bytes())),
            Self::F64(values) => all(out, values.iter().map(|value| value.to_le_bytes())),
        }
    }
}

/// A file that is being written. It holds 32 bytes of memory for each chunk.
pub(super) struct Writer<'a, W> {
    out: &'a mut W,
    /// Length of the file so far (bytes).
    length: u64,
    /// Names in order of first use; their places are their numbers.
    names: Vec<&'static str>,
    frame: u64,
    /// Entries of the present frame, with the numbers of their names.
    present: Vec<(u16, [u8; 32])>,
    index: Vec<u8>,
}

impl<'a, W: Write + Seek> Writer<'a, W> {
    /// Leaves room for the header.
    pub(super) fn new(out: &'a mut W) -> io::Result<Self> {
        out.write_all(&[0; HEADER as usize])?;
        Ok(Self {
            out,
            length: HEADER,
            names: Vec::new(),
            frame: 0,
            present: Vec::new(),
            index: Vec::new(),
        })
    }

    /// Writes an array with `columns` columns into the present frame; a name occurs once in it.
    pub(super) fn chunk(
        &mut self,
        name: &'static str,
        data: &Data,
        columns: usize,
    ) -> io::Result<()> {
        let number = self
            .names
            .iter()
            .position(|known| *known == name)
            .unwrap_or_else(|| {
                self.names.push(name);
                self.names.len() - 1
            }) as u16;
        let mut entry = [0; 32];
        entry[..8].copy_from_slice(&self.frame.to_le_bytes());
        entry[8..16].copy_from_slice(&((data.len() / columns) as u64).to_le_bytes());
        entry[16..24].copy_from_slice(&self.length.to_le_bytes());
        entry[24..28].copy_from_slice(&(columns as u32).to_le_bytes());
        entry[28..30].copy_from_slice(&number.to_le_bytes());
        entry[30] = data.code();
        self.present.push((number, entry));
        self.length += data.write(self.out)?;
        Ok(())
    }

    /// Ends the present frame.
    pub(super) fn end_frame(&mut self) {
        self.present.sort_by_key(|entry| entry.0);
        self.index
            .extend(self.present.drain(..).flat_map(|entry| entry.1));
        self.frame += 1;
    }

    /// Writes the index, the list of names and the header for files of `schema` in `version`.
    pub(super) fn end(self, schema: &str, version: [u16; 2]) -> io::Result<()> {
        self.out.write_all(&self.index)?;
        let mut names: Vec<u8> = self
            .names
            .iter()
            .flat_map(|name| name.bytes().chain([0]))
            .collect();
        // An empty name ends the list.
        names.resize((names.len() + 1).next_multiple_of(NAME), 0);
        self.out.write_all(&names)?;
        let mut header = Vec::with_capacity(HEADER as usize);
        let entries = (self.index.len() / 32) as u64;
        let names_at = self.length + self.index.len() as u64;
        for number in [
            MAGIC,
            self.length,
            entries,
            names_at,
            (names.len() / NAME) as u64,
        ] {
            header.extend(number.to_le_bytes());
        }
        header.extend((u32::from(version[0]) << 16 | u32::from(version[1])).to_le_bytes());
        header.extend(LAYER.to_le_bytes());
        for text in [concat!("carom ", env!("CARGO_PKG_VERSION")), schema] {
            let mut field = text.as_bytes().to_vec();
            field.resize(64, 0);
            header.extend(field);
        }
        header.resize(HEADER as usize, 0);
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&header)
    }
}
