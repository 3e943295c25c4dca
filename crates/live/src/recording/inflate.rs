//! Recordings that another program has compressed, as if they were not.
//!
//! A recording of this program is not compressed; `mcap compress` and Foxglove make one of it
//! that is (MCAP specification, <https://mcap.dev/spec#chunk-op0x06>). Compressed chunks are
//! rewritten while they are read; everything else passes as it is, so that a file which was
//! cut off ends where it ends.

use crc32fast::Hasher;
use std::io::{Error, ErrorKind, Read, Result};

/// What a file begins with.
const MAGIC: usize = 8;
const MAGIC_BYTES: [u8; MAGIC] = *b"\x89MCAP0\r\n";
/// A record: its kind, its length.
const RECORD: usize = 1 + 8;
/// The kind of a chunk.
const CHUNK: u8 = 0x06;
/// The kind of the record that ends the data, with their checksum.
const DATA_END: u8 = 0x0f;
/// Of a chunk: times of the first and the last message, size and checksum of its content.
const CHUNK_FIXED: usize = 8 + 8 + 8 + 4;
/// Longer names of compressions are damage.
const LONGEST_NAME: u64 = 32;
/// A chunk is at most so large [bytes].
const LARGEST: u64 = 1 << 28;

/// Reads an MCAP file, its chunks decompressed.
#[derive(Debug)]
pub struct Inflate<R> {
    file: R,
    /// What is ready to be read, from `taken` on.
    ready: Vec<u8>,
    taken: usize,
    /// How much of the file is to be passed on as it is.
    passing: u64,
    /// Whether the file has ended, or a record that it breaks off in.
    is_over: bool,
    /// Checksum of the file as it is, up to the end of its data.
    sum: Option<Hasher>,
    is_damaged: bool,
    is_torn: bool,
}

impl<R: Read> Inflate<R> {
    /// The file from its beginning.
    pub fn new(file: R) -> Self {
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

    /// Whether the checksum of the whole file is wrong, as far as it has been read; there
    /// may be none.
    pub fn is_damaged(&self) -> bool {
        self.is_damaged
    }

    /// Whether the file has ended in the midst of a record.
    pub fn is_torn(&self) -> bool {
        self.is_torn
    }

    /// Adds what is `ready` from `start` on to the checksum.
    fn add(&mut self, start: usize) {
        if let Some(sum) = &mut self.sum {
            sum.update(&self.ready[start..]);
        }
    }

    /// Compares the checksum with the one that the end of the data says.
    fn end_data(&mut self) {
        let said = number(&self.ready[RECORD..]) as u32;
        if let Some(sum) = self.sum.take() {
            self.is_damaged = said != 0 && said != sum.finalize();
        }
    }

    /// Reads up to `count` bytes into `ready`; whether there were so many.
    fn take(&mut self, count: u64) -> Result<bool> {
        let before = self.ready.len();
        let read = self.file.by_ref().take(count).read_to_end(&mut self.ready);
        read?;
        let is_whole = (self.ready.len() - before) as u64 == count;
        // A file may end before a record, and after the last one there are eight bytes more.
        self.is_torn = !is_whole && !self.ready.is_empty() && self.ready != MAGIC_BYTES;
        Ok(is_whole)
    }

    /// Makes the beginning of the next record ready, or the whole of it if it is a
    /// compressed chunk.
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
        let fixed = CHUNK_FIXED as u64 + 4;
        if self.ready[0] != CHUNK || length < fixed {
            self.passing = length;
            return Ok(());
        }
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
            // Just enough for a record that breaks off.
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

/// Up to eight bytes as a number, the least first.
fn number(bytes: &[u8]) -> u64 {
    let digits = bytes.iter().take(8).rev();
    digits.fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// The content of a chunk, which says that it is of `size` bytes.
fn decompressed(compression: &[u8], content: &[u8], size: u64) -> Result<Vec<u8>> {
    let damaged = |problem: String| Error::new(ErrorKind::InvalidData, problem);
    if size > LARGEST {
        return Err(damaged(format!("a chunk of {size} bytes")));
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
            "a chunk of another size than {size} bytes"
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
            // Cut off anywhere it ends early, and is never taken for more.
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
