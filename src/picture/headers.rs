//! What is looked at in a picture's bytes before its decoder sees them: sizes that it would misread, tables on which it
//! would fail, and where a scan ends.

/// Columns and rows by a PNG's header, before its decoder sets memory aside for a row.
pub(crate) fn png_size(bytes: &[u8]) -> Option<(u64, u64)> {
    let number = |at: usize| Some(u32::from_be_bytes(*bytes.get(at..)?.first_chunk()?).into());
    (bytes.get(12..16)? == b"IHDR").then_some((number(16)?, number(20)?))
}

/// Length in bytes of a PNG's palette if it is not 1 to 256 colours of three bytes (PNG specification, 11.2.2).
pub(crate) fn wrong_png_palette(bytes: &[u8]) -> Option<usize> {
    let mut at = 8;
    while let Some((length, rest)) = bytes.get(at..).and_then(|chunk| chunk.split_first_chunk()) {
        let length = u32::from_be_bytes(*length) as usize;
        match rest.first_chunk()? {
            b"PLTE" if length == 0 || length > 3 * 256 || !length.is_multiple_of(3) => return Some(length),
            b"IDAT" | b"IEND" => return None,
            // The chunk's length, kind and checksum have four bytes each.
            _ => at = at.checked_add(length)?.checked_add(12)?,
        }
    }
    None
}

/// Columns and rows by a WebP's first chunk. Its decoder takes a lossless picture 16384 wide for one without width.
pub(crate) fn webp_size(bytes: &[u8]) -> Option<(u64, u64)> {
    let data = bytes.get(20..)?;
    match bytes.get(12..16)? {
        // Signature, then 14 bits each of width - 1 and height - 1.
        b"VP8L" => {
            let bits = u64::from(u32::from_le_bytes(*data.get(1..)?.first_chunk()?));
            Some(((bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1))
        }
        // Four bytes of flags, then 24 bits each of width - 1 and height - 1.
        b"VP8X" => {
            let number = |at: usize| data.get(at..at + 3).map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], 0])));
            Some((number(4)? + 1, number(7)? + 1))
        }
        _ => None,
    }
}

/// What a JPEG's markers say of its end.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum JpegEnd {
    /// The end marker stands here, behind the first scan.
    At(usize),
    /// A scan begins and nothing ends it.
    Missing,
    /// There is no scan: the decoder knows better what to say.
    NoScan,
}

/// Where a JPEG's picture ends. Only what follows the first scan counts: a thumbnail before it has an end of its own.
pub(crate) fn jpeg_end(bytes: &[u8]) -> JpegEnd {
    let mut at = 2;
    let mut scanned = false;
    while let Some(&[mark, kind]) = bytes.get(at..).and_then(|rest| rest.first_chunk()) {
        match (mark, kind) {
            (0xff, 0xd9) if scanned => return JpegEnd::At(at),
            (0xff, 0xff) => at += 1,
            // In the data of a scan, a zero follows a byte that looks like a mark.
            (0xff, 0 | 0x01 | 0xd0..=0xd9) => at += 2,
            (0xff, _) => {
                scanned |= kind == 0xda;
                let length = bytes.get(at + 2..).and_then(|rest| rest.first_chunk());
                at += 2 + usize::from(length.map_or(0, |length| u16::from_be_bytes(*length)));
            }
            // The data of a scan, or stray bytes between segments: the decoder skips those, and so do we.
            _ => at += 1,
        }
    }
    if scanned { JpegEnd::Missing } else { JpegEnd::NoScan }
}
