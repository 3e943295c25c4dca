//! Decompression of recordings that another program has compressed.
//!
//! This program does not compress its recordings, but `mcap compress` and Foxglove do (MCAP
//! specification, <https://mcap.dev/spec#chunk-op0x06>). Compressed chunks are rewritten while they
//! are read. Everything else passes unchanged, so that a truncated file ends at the same point.

use crc32fast::Hasher;
use std::io::{Error, ErrorKind, Read, Result};

/// Length of the magic bytes at the start of a file.
const MAGIC: usize = 8;
const MAGIC_BYTES: [u8; MAGIC] = *b"\x89MCAP0\r\n";
/// Length of a record's kind and size.
const RECORD: usize = 1 + 8;
/// The record kind of a chunk.
const CHUNK: u8 = 0x06;
/// The record kind of the end of the data, with their checksum.
const DATA_END: u8 = 0x0f;
/// Length of a chunk's fixed fields: times of the first and last message, size and checksum of its
/// content.
const CHUNK_FIXED: usize = 8 + 8 + 8 + 4;
/// A longer compression name means damage.
const LONGEST_NAME: u64 = 32;
/// Maximum size of a chunk [bytes].
const LARGEST: u64 = 1 << 28;

/// Reads an MCAP file and decompresses its chunks.
#[derive(Debug)]
pub(super) struct Inflate<R> {
    file: R,
    /// Bytes ready to be read, from `taken` on.
    ready: Vec<u8>,
    taken: usize,
    /// Number of bytes of the file still to be passed on unchanged.
    passing: u64,
    /// Whether the file has ended, perhaps within a record.
    is_over: bool,
    /// Checksum of the original file, up to the end of its data.
    sum: Option<Hasher>,
    is_damaged: bool,
    is_torn: bool,
}

impl<R: Read> Inflate<R> {
    /// A reader of the file from its beginning.
    pub(super) fn new(file: R) -> Self {
        Self {
            file,
            ready: Vec::new(),
            taken: 0,
            passing: MAGIC as u64,
            is_over: false,
            sum: Some(Hasher::new()),
            is_damaged: false,
            is_torn: false,
        }
    }

    /// Whether the checksum of the file's data is wrong, if it has one and that has been read.
    pub(super) fn is_damaged(&self) -> bool {
        self.is_damaged
    }

    /// Whether the file has ended within a record.
    pub(super) fn is_torn(&self) -> bool {
        self.is_torn
    }

    /// Adds the `ready` bytes from `start` on to the checksum.
    fn add(&mut self, start: usize) {
        if let Some(sum) = &mut self.sum {
            sum.update(&self.ready[start..]);
        }
    }

    /// Compares the checksum with the one in the end-of-data record.
    fn end_data(&mut self) {
        let said = number(&self.ready[RECORD..]) as u32;
        if let Some(sum) = self.sum.take() {
            self.is_damaged = said != 0 && said != sum.finalize();
        }
    }

    /// Reads up to `count` bytes into `ready`. Returns whether there were that many.
    fn take(&mut self, count: u64) -> Result<bool> {
        let before = self.ready.len();
        let read = self.file.by_ref().take(count).read_to_end(&mut self.ready);
        read?;
        let is_whole = (self.ready.len() - before) as u64 == count;
        // A file may end between records; after the last one there are the eight magic bytes.
        self.is_torn = !is_whole && !self.ready.is_empty() && self.ready != MAGIC_BYTES;
        Ok(is_whole)
    }

    /// Prepares the start of the next record, or the whole record if it is a compressed chunk.
    fn next_record(&mut self) -> Result<()> {
        self.ready.clear();
        self.taken = 0;
        if !self.take(RECORD as u64)? {
            self.is_over = true;
            return Ok(());
        }
        let length = number(&self.ready[1..RECORD]);
        if self.ready[0] == DATA_END && length == 4 {
            match self.take(4)? {
                true => self.end_data(),
                false => self.is_over = true,
            }
            return Ok(());
        }
        self.add(0);
        if self.ready[0] != CHUNK || length < CHUNK_FIXED as u64 + 4 {
            self.passing = length;
            return Ok(());
        }
        self.next_chunk(length)
    }

    /// Prepares a chunk of `length` bytes, of which nothing but the start of the record was read: if
    /// it is compressed, whole and without compression.
    fn next_chunk(&mut self, length: u64) -> Result<()> {
        let fixed = CHUNK_FIXED as u64 + 4;
        let start = self.ready.len();
        if !self.take(fixed)? {
            self.is_over = true;
            return Ok(());
        }
        self.add(start);
        let name = number(&self.ready[RECORD + CHUNK_FIXED..]);
        let head = fixed + name + 8;
        if name > LONGEST_NAME || length < head {
            self.passing = length - fixed;
            return Ok(());
        }
        let start = self.ready.len();
        if !self.take(name + 8)? {
            self.is_over = true;
            return Ok(());
        }
        self.add(start);
        let at = RECORD + fixed as usize;
        let compression = self.ready[at..at + name as usize].to_vec();
        let (content, size) = (length - head, number(&self.ready[RECORD + 16..RECORD + 24]));
        if ![&b"lz4"[..], b"zstd"].contains(&&compression[..]) || content > LARGEST {
            self.passing = content;
            return Ok(());
        }
        let head = self.ready.len();
        if !self.take(content)? {
            // Just enough to be a truncated record.
            self.ready.truncate(RECORD);
            self.is_over = true;
            return Ok(());
        }
        self.add(head);
        let bytes = decompressed(&compression, &self.ready[head..], size)?;
        let fixed = self.ready[RECORD..RECORD + CHUNK_FIXED].to_vec();
        self.ready.clear();
        self.ready.push(CHUNK);
        let length = CHUNK_FIXED as u64 + 4 + 8 + bytes.len() as u64;
        self.ready.extend(length.to_le_bytes());
        self.ready.extend(fixed);
        // No compression.
        self.ready.extend(0u32.to_le_bytes());
        self.ready.extend((bytes.len() as u64).to_le_bytes());
        self.ready.extend(bytes);
        Ok(())
    }
}

impl<R: Read> Read for Inflate<R> {
    fn read(&mut self, to: &mut [u8]) -> Result<usize> {
        loop {
            if self.taken < self.ready.len() {
                let read = (&self.ready[self.taken..]).read(to)?;
                self.taken += read;
                return Ok(read);
            }
            if self.passing > 0 {
                let most = to
                    .len()
                    .min(usize::try_from(self.passing).unwrap_or(usize::MAX));
                let read = self.file.read(&mut to[..most])?;
                self.passing -= read as u64;
                self.is_torn = read == 0 && !to.is_empty();
                if let Some(sum) = &mut self.sum {
                    sum.update(&to[..read]);
                }
                return Ok(read);
            }
            if self.is_over {
                return Ok(0);
            }
            self.next_record()?;
        }
    }
}

/// Up to eight bytes as a little-endian number.
fn number(bytes: &[u8]) -> u64 {
    let digits = bytes.iter().take(8).rev();
    digits.fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// Decompresses the content of a chunk, whose stated size is `size` bytes.
fn decompressed(compression: &[u8], content: &[u8], size: u64) -> Result<Vec<u8>> {
    let damaged = |problem: String| Error::new(ErrorKind::InvalidData, problem);
    if size > LARGEST {
        return Err(damaged(format!("a chunk is too large: {size} bytes")));
    }
    let mut bytes = Vec::new();
    let read = match compression {
        b"lz4" => {
            let decoder = lz4_flex::frame::FrameDecoder::new(content);
            decoder.take(size + 1).read_to_end(&mut bytes)
        }
        _ => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(content);
            let decoder = decoder.map_err(|error| damaged(error.to_string()))?;
            decoder.take(size + 1).read_to_end(&mut bytes)
        }
    };
    read.map_err(|error| damaged(error.to_string()))?;
    if bytes.len() as u64 != size {
        return Err(damaged(format!(
            "a chunk does not have its stated size of {size} bytes"
        )));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: u8, content: &[u8]) -> Vec<u8> {
        let length = (content.len() as u64).to_le_bytes();
        [&[kind][..], &length, content].concat()
    }

    fn chunk(compression: &str, size: usize, content: &[u8]) -> Vec<u8> {
        let mut fields = vec![7; 16];
        fields.extend((size as u64).to_le_bytes());
        fields.extend([1, 2, 3, 4]);
        fields.extend((compression.len() as u32).to_le_bytes());
        fields.extend(compression.as_bytes());
        fields.extend((content.len() as u64).to_le_bytes());
        fields.extend(content);
        record(CHUNK, &fields)
    }

    fn read(file: &[u8]) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Inflate::new(file).read_to_end(&mut bytes).map(|_| bytes)
    }

    #[test]
    fn the_checksum_of_the_data_is_compared() {
        let data = [
            b"12345678".to_vec(),
            record(1, b"header"),
            chunk("", 3, b"abc"),
        ]
        .concat();
        let damaged = |sum: u32, place: Option<usize>| {
            let mut file = [data.clone(), record(DATA_END, &sum.to_le_bytes())].concat();
            file.extend(record(2, b"footer"));
            if let Some(place) = place {
                file[place] ^= 1;
            }
            let mut reader = Inflate::new(&file[..]);
            let mut bytes = Vec::new();
            reader.read_to_end(&mut bytes).unwrap();
            assert_eq!(bytes, file);
            reader.is_damaged()
        };
        let sum = crc32fast::hash(&data);
        assert!(!damaged(sum, None) && damaged(sum ^ 1, None) && !damaged(0, None));
        for place in [3, 18, data.len() - 1] {
            assert!(damaged(sum, Some(place)), "{place}");
        }
    }

    #[test]
    fn chunks_are_decompressed_and_all_else_passes() {
        use std::io::Write as _;
        let content = b"a message, a message, a message, another message".repeat(20);
        let mut lz4 = lz4_flex::frame::FrameEncoder::new(Vec::new());
        lz4.write_all(&content).unwrap();
        let lz4 = lz4.finish().unwrap();
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        let zstd = ruzstd::encoding::compress_to_vec(&content[..], level);
        let file = |chunk: Vec<u8>| {
            let parts = [
                b"12345678".to_vec(),
                record(1, b"header"),
                chunk,
                record(2, b""),
            ];
            parts.concat()
        };
        let plain = file(chunk("", content.len(), &content));
        assert_eq!(read(&plain).unwrap(), plain);
        for (name, bytes) in [("lz4", &lz4), ("zstd", &zstd)] {
            let whole = file(chunk(name, content.len(), bytes));
            assert!(whole.len() < plain.len());
            assert_eq!(read(&whole).unwrap(), plain);
            assert!(read(&file(chunk(name, content.len() - 1, bytes))).is_err());
            assert!(read(&file(chunk(name, 1 << 40, bytes))).is_err());
            // Truncated anywhere, it ends early and is never read as more.
            for length in 0..whole.len() {
                let part = read(&whole[..length]).unwrap();
                assert!(part.len() < plain.len());
            }
            for place in 0..whole.len() {
                let mut damaged = whole.clone();
                damaged[place] ^= 0x55;
                let _ = read(&damaged);
            }
        }
        let unknown = file(chunk("snappy", 3, b"abc"));
        assert_eq!(read(&unknown).unwrap(), unknown);
    }
}
