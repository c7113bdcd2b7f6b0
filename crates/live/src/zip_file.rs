//! Archives (ZIP) of a few small files, which are stored without compression.

/// First bytes of the parts of an archive (PKWARE APPNOTE 6.3.10, 4.3).
const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;

/// Version of the format: 2.0.
const VERSION: u16 = 20;

/// Names are UTF-8.
const FLAGS: u16 = 1 << 11;

/// 1 January 1980, the first date of the format.
const DATE: u16 = 1 << 5 | 1;

/// The archive of files with names and contents, 4 GiB at most.
pub fn archive(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut bytes, mut central) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let offset = bytes.len() as u32;
        let head = head(name, content);
        bytes.extend(LOCAL.to_le_bytes());
        bytes.extend(&head);
        bytes.extend(name.as_bytes());
        bytes.extend(content);
        central.extend(CENTRAL.to_le_bytes());
        central.extend(VERSION.to_le_bytes());
        central.extend(&head);
        // No comment, the first disk, no attributes.
        central.extend([0; 10]);
        central.extend(offset.to_le_bytes());
        central.extend(name.as_bytes());
    }
    let (offset, count) = (bytes.len() as u32, files.len() as u16);
    bytes.extend(&central);
    bytes.extend(END.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend([count; 2].iter().flat_map(|count| count.to_le_bytes()));
    bytes.extend((central.len() as u32).to_le_bytes());
    bytes.extend(offset.to_le_bytes());
    bytes.extend([0; 2]);
    bytes
}

/// What the two entries of a file have in common.
fn head(name: &str, content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Stored, at midnight.
    for word in [VERSION, FLAGS, 0, 0, DATE] {
        bytes.extend(word.to_le_bytes());
    }
    let length = content.len() as u32;
    for word in [crc32fast::hash(content), length, length] {
        bytes.extend(word.to_le_bytes());
    }
    for word in [name.len() as u16, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_at_the_end_leads_to_each_file() {
        let files = [("a", "first"), ("b/c", "second file")];
        let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
        let bytes = archive(&files);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let half = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let end = bytes.len() - 22;
        assert_eq!((word(end), half(end + 10)), (END as usize, 2));
        let mut at = word(end + 16);
        for (name, content) in &files {
            assert_eq!(word(at), CENTRAL as usize);
            let (local, length) = (word(at + 42), half(at + 28));
            assert_eq!(&bytes[at + 46..at + 46 + length], name.as_bytes());
            assert_eq!(word(local), LOCAL as usize);
            let begin = local + 30 + half(local + 26);
            assert_eq!(&bytes[begin..begin + word(local + 18)], &content[..]);
            at += 46 + length;
        }
        assert_eq!(at, end);
    }
}
