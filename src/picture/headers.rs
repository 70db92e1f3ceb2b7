//! What is looked at in a picture's bytes before its decoder sees them: sizes that it would misread, tables on which it
//! would fail, and where a scan ends.

/// Columns and rows by a PNG's header, before its decoder sets memory aside for a row.
pub(crate) fn png_size(bytes: &[u8]) -> Option<(u64, u64)> {
    let number = |at: usize| Some(u32::from_be_bytes(*bytes.get(at..)?.first_chunk()?).into());
    (bytes.get(12..16)? == b"IHDR").then_some((number(16)?, number(20)?))
}

/// The chunks of a PNG that are there as a whole: kind and content.
pub(crate) fn png_chunks(bytes: &[u8]) -> impl Iterator<Item = (&[u8; 4], &[u8])> {
    let mut rest = bytes.get(8..).unwrap_or_default();
    std::iter::from_fn(move || {
        let (length, after) = rest.split_first_chunk()?;
        let (kind, after) = after.split_first_chunk()?;
        let (content, after) = after.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        // Four bytes of checksum.
        rest = after.get(4..)?;
        Some((kind, content))
    })
}

/// Length in bytes of a PNG's palette if it is not 1 to 256 colours of three bytes (PNG specification, 11.2.2).
pub(crate) fn wrong_png_palette(bytes: &[u8]) -> Option<usize> {
    let before = png_chunks(bytes).take_while(|(kind, _)| !matches!(*kind, b"IDAT" | b"IEND"));
    let mut lengths = before.filter(|(kind, _)| *kind == b"PLTE").map(|(_, content)| content.len());
    lengths.find(|&length| length == 0 || length > 3 * 256 || !length.is_multiple_of(3))
}

/// A PNG that has no end, ended where its bytes do; `None` if it has an end, or no data to end.
pub(crate) fn ended_png(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut ended = bytes.get(..8)?.to_vec();
    let mut data = false;
    let add = |ended: &mut Vec<u8>, kind: &[u8; 4], content: &[u8]| {
        ended.extend((content.len() as u32).to_be_bytes());
        ended.extend(kind);
        ended.extend(content);
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(kind);
        checksum.update(content);
        ended.extend(checksum.finalize().to_be_bytes());
    };
    let mut whole = 8;
    for (kind, content) in png_chunks(bytes) {
        if kind == b"IEND" {
            return None;
        }
        data |= kind == b"IDAT";
        ended.extend(&bytes[whole..whole + content.len() + 12]);
        whole += content.len() + 12;
    }
    // What is there of the chunk in which the bytes end; of its checksum, too, where that is what is cut.
    if let Some((length, rest)) = bytes[whole..].split_first_chunk()
        && let Some((b"IDAT", content)) = rest.split_first_chunk()
    {
        let length = u32::from_be_bytes(*length) as usize;
        add(&mut ended, b"IDAT", &content[..content.len().min(length)]);
        data = true;
    }
    add(&mut ended, b"IEND", &[]);
    data.then_some(ended)
}

/// Whether a PNG or a WebP says that it moves.
pub(crate) fn moves(bytes: &[u8]) -> bool {
    match bytes.get(..4) {
        Some(b"RIFF") => bytes.get(12..16) == Some(b"VP8X") && bytes.get(20).is_some_and(|flags| flags & 2 != 0),
        _ => png_chunks(bytes).take_while(|(kind, _)| *kind != b"IDAT").any(|(kind, _)| kind == b"acTL"),
    }
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

/// The number that stands for white in a PGM, PPM or PAM file.
pub(crate) fn netpbm_white(bytes: &[u8]) -> Option<u32> {
    let head = &bytes[..bytes.len().min(1 << 16)];
    let kind = *head.get(1)?;
    if kind == b'7' {
        let line = head.split(|byte| *byte == b'\n').find_map(|line| line.strip_prefix(b"MAXVAL"))?;
        return str::from_utf8(line).ok()?.trim().parse().ok();
    }
    if !matches!(kind, b'2' | b'3' | b'5' | b'6') {
        return None;
    }
    // Columns, rows, white; comments go to the end of their line.
    let mut words = Vec::new();
    for line in head[2..].split(|byte| matches!(byte, b'\n' | b'\r')) {
        let said = line.split(|byte| *byte == b'#').next().unwrap_or_default();
        words.extend(said.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()));
        if words.len() > 2 {
            return str::from_utf8(words[2]).ok()?.parse().ok();
        }
    }
    None
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_of_a_netpbm_is_its_third_number_whatever_stands_between() {
        for (text, white) in [
            ("P5 2 2 15\nxxxx", Some(15)),
            ("P2\n# by hand\n2 # wide\n2\n# white:\n1023\n0 1", Some(1023)),
            ("P6\r\n2 2\r\n65535\r\n", Some(65535)),
            ("P7\nWIDTH 2\nHEIGHT 2\nDEPTH 1\nMAXVAL 100\nTUPLTYPE GRAYSCALE\nENDHDR\n", Some(100)),
            ("P4 2 2\n", None),
            ("P5 2 2", None),
        ] {
            assert_eq!(netpbm_white(text.as_bytes()), white, "{text}");
        }
    }
}
