//! What a file is, by its first bytes.

use image::ImageFormat;

use super::PictureError;

/// This many bytes are enough to tell.
pub(crate) const ENOUGH: u64 = 1 << 16;

const EXPORT: &str = "export it as PNG";
const DRAWING: &str = "export it as PNG, 1000 pixels wide or more";
const PHOTOGRAPH: &str = "export it as JPEG or PNG";

/// Beginnings of what people mistake for a picture that is read: offset, bytes, what it is, what would do.
const OTHERS: [(usize, &[u8], &str, &str); 32] = [
    (0, b"%PDF", "a PDF document", DRAWING),
    (0, b"%!PS", "a PostScript document", DRAWING),
    (0, b"\xc5\xd0\xd3\xc6", "a PostScript document", DRAWING),
    (0, b"8BPS", "a Photoshop document", EXPORT),
    (0, b"gimp xcf", "a GIMP document", EXPORT),
    (0, b"\0\0\x01\0", "an icon", EXPORT),
    (0, b"\0\0\x02\0", "a cursor", EXPORT),
    (4, b"ftypavi", "an AVIF picture", EXPORT),
    (4, b"ftyphei", "a HEIC photograph", PHOTOGRAPH),
    (4, b"ftyphev", "a HEIC photograph", PHOTOGRAPH),
    (4, b"ftypmif1", "a HEIC or AVIF picture", PHOTOGRAPH),
    (4, b"ftypmsf1", "a HEIC photograph", PHOTOGRAPH),
    (4, b"ftypcrx", RAW, DEVELOP),
    (4, b"ftyp", "a film or a rare kind of picture", EXPORT),
    (0, b"IIU\0", RAW, DEVELOP),
    (0, b"IIRO", RAW, DEVELOP),
    (0, b"IIRS", RAW, DEVELOP),
    (0, b"MMOR", RAW, DEVELOP),
    (0, b"FUJIFILMCCD-RAW", RAW, DEVELOP),
    (0, b"FOVb", RAW, DEVELOP),
    (0, b"\0MRM", RAW, DEVELOP),
    (6, b"HEAPCCDR", RAW, DEVELOP),
    (8, b"CR\x02\0", RAW, DEVELOP),
    (0, b"\0\0\0\x0cJXL ", "a JPEG XL picture", EXPORT),
    (0, b"\xff\x0a", "a JPEG XL picture", EXPORT),
    (0, b"\0\0\0\x0cjP  ", "a JPEG 2000 picture", EXPORT),
    (0, b"\xff\x4f\xff\x51", "a JPEG 2000 picture", EXPORT),
    (0, b"qoif", "a QOI picture", EXPORT),
    (0, b"DDS ", "a DDS texture", EXPORT),
    (0, b"PK\x03\x04", "a zip archive or a document packed as one", "take the picture out of it as PNG"),
    (0, b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (0, b"\x93NUMPY", "a NumPy array", "save it as 16-bit PNG or float TIFF"),
];

const RAW: &str = "a camera's raw photograph";
const DEVELOP: &str = "develop it and export it as 16-bit PNG or TIFF";

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// The general decoder knows it.
    General(ImageFormat),
    /// TIFF, BigTIFF too.
    Tiff,
    /// OpenEXR.
    #[cfg(feature = "exr")]
    Exr,
    /// SVG.
    #[cfg(feature = "svg")]
    Svg,
}

impl Format {
    /// The format's name as people write it.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::General(ImageFormat::Png) => "PNG",
            Self::General(ImageFormat::Jpeg) => "JPEG",
            Self::General(ImageFormat::WebP) => "WebP",
            Self::General(ImageFormat::Gif) => "GIF",
            Self::General(ImageFormat::Bmp) => "BMP",
            Self::General(ImageFormat::Hdr) => "Radiance HDR",
            Self::General(_) => "PBM, PGM or PPM",
            Self::Tiff => "TIFF",
            #[cfg(feature = "exr")]
            Self::Exr => "OpenEXR",
            #[cfg(feature = "svg")]
            Self::Svg => "SVG",
        }
    }
}

/// What is read, for messages.
pub(crate) const READ: &str = if cfg!(all(feature = "exr", feature = "svg")) {
    "PNG, JPEG, TIFF, WebP, GIF, BMP, PGM, PPM, Radiance HDR, OpenEXR and SVG"
} else {
    "PNG, JPEG, TIFF, WebP, GIF, BMP, PGM, PPM and Radiance HDR"
};

/// The format of a file that begins with `bytes`, one of those that are read.
pub(crate) fn format(bytes: &[u8], name: &str) -> Result<Format, PictureError> {
    if bytes.is_empty() {
        return Err(PictureError::Empty { name: name.into() });
    }
    if let Some(error) = other(bytes, name) {
        return Err(error);
    }
    // BigTIFF begins otherwise than TIFF.
    if [&b"II\x2a\0"[..], b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|mark| bytes.starts_with(mark)) {
        return Ok(Format::Tiff);
    }
    #[cfg(feature = "exr")]
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        return Ok(Format::Exr);
    }
    match image::guess_format(bytes) {
        Ok(
            format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Gif | ImageFormat::Hdr),
        ) => {
            return Ok(Format::General(format));
        }
        // Two letters are no proof: a bitmap also has four bytes that are zero.
        Ok(ImageFormat::Bmp) if bytes.get(6..10).is_some_and(|reserved| reserved == [0; 4]) => {
            return Ok(Format::General(ImageFormat::Bmp));
        }
        _ if is_netpbm(bytes) => return Ok(Format::General(ImageFormat::Pnm)),
        _ => {}
    }
    #[cfg(feature = "svg")]
    if is_svg(bytes) {
        return Ok(Format::Svg);
    }
    let (found, remedy) = describe(bytes);
    Err(PictureError::Format { name: name.into(), found, remedy })
}

/// The refusal of a file of another format that says by its first bytes what it is.
fn other(bytes: &[u8], name: &str) -> Option<PictureError> {
    let begins = |at: usize, mark: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(mark));
    let (_, _, found, remedy) = OTHERS.iter().find(|(at, mark, ..)| begins(*at, mark))?;
    Some(PictureError::Format { name: name.into(), found, remedy })
}

/// A root element of this name before one of a web page.
fn is_svg(bytes: &[u8]) -> bool {
    let text = beginning(bytes);
    let svg =
        text.find("<svg").filter(|at| text[at + 4..].starts_with(|c: char| c.is_whitespace() || ">:".contains(c)));
    svg.is_some_and(|svg| ["<html", "<!doctype html"].iter().all(|page| text.find(page).is_none_or(|page| page > svg)))
}

/// Small letters of what may be text, UTF-8 or UTF-16; nothing if it is none.
fn beginning(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(ENOUGH as usize)];
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return head
            .iter()
            .filter(|byte| byte.is_ascii() && **byte != 0)
            .map(|b| b.to_ascii_lowercase() as char)
            .collect();
    }
    // A character cut in two at the end of the head is still text.
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(e) if e.error_len().is_none() => std::str::from_utf8(&head[..e.valid_up_to()]).unwrap_or(""),
        Err(_) => "",
    };
    text.to_ascii_lowercase()
}

/// What bytes of no readable format look like, and what would do.
fn describe(bytes: &[u8]) -> (&'static str, &'static str) {
    let head = &bytes[..bytes.len().min(ENOUGH as usize)];
    if head.iter().all(|b| *b == 0) {
        return ("nothing but zero bytes", "save or download the picture again");
    }
    let text = beginning(bytes);
    if is_svg(bytes) {
        ("an SVG drawing", DRAWING)
    } else if text.contains("<html") || text.contains("<!doctype html") {
        ("a web page", "download the picture itself")
    } else if head.starts_with(b"\x76\x2f\x31\x01") {
        ("an OpenEXR picture", "export it as 16-bit PNG or float TIFF")
    } else if text.starts_with("solid ") {
        ("an STL mesh", "give the drawing of the highlight")
    } else if !text.is_empty() && !text.contains(|c: char| c.is_control() && !c.is_whitespace()) {
        ("a text file", "give the drawing of the highlight")
    } else {
        ("a file of unknown kind", "save or export the picture as PNG")
    }
}

/// "P1" to "P7" and white space.
fn is_netpbm(head: &[u8]) -> bool {
    matches!(head, [b'P', b'1'..=b'7', space, ..] if space.is_ascii_whitespace())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(bytes: &[u8]) -> String {
        format(bytes, "a.png").unwrap_err().to_string()
    }

    #[test]
    fn content_decides_and_the_message_says_what_it_is_and_what_would_do() {
        for (bytes, wanted) in [
            (&b"\x89PNG\r\n\x1a\n"[..], Format::General(ImageFormat::Png)),
            (b"\xff\xd8\xff\xe0", Format::General(ImageFormat::Jpeg)),
            (b"II*\0", Format::Tiff),
            (b"MM\0\x2b", Format::Tiff),
            (b"RIFF1234WEBPVP8 ", Format::General(ImageFormat::WebP)),
            (b"GIF89a\x01\0\x01\0", Format::General(ImageFormat::Gif)),
            (b"BM\x20\0\0\0\0\0\0\0", Format::General(ImageFormat::Bmp)),
            (b"P5 2 2 255\n1234", Format::General(ImageFormat::Pnm)),
            (b"#?RADIANCE\n", Format::General(ImageFormat::Hdr)),
            #[cfg(feature = "exr")]
            (b"\x76\x2f\x31\x01", Format::Exr),
            #[cfg(feature = "svg")]
            (b"<?xml version='1.0'?>\n<SVG xmlns=''>", Format::Svg),
            #[cfg(feature = "svg")]
            (b"\xff\xfe<\0s\0v\0g\0>\0", Format::Svg),
            #[cfg(feature = "svg")]
            (b"<svg:svg xmlns:svg=''>", Format::Svg),
        ] {
            assert_eq!(format(bytes, "a.png").unwrap(), wanted);
        }
        for (bytes, word) in [
            (&b"%PDF-1.7"[..], "PDF"),
            (b"P5", "text"),
            (b"BM1 is the name of a text", "text"),
            (b"<!DOCTYPE html><html><svg>", "web page"),
            ("Grüße, 漢".as_bytes(), "a text file"),
            (&"漢".as_bytes()[..2], "unknown kind"),
            (b"\0\0\0\x20ftypheic", "HEIC"),
            (b"\0\0\0\x20ftypavif", "AVIF"),
            (b"II*\0\x10\0\0\0CR\x02\0", "raw photograph"),
            (b"FUJIFILMCCD-RAW 0201", "raw photograph"),
            (b"\0\0\0\0\0\0", "zero bytes"),
            (b"\x01\x02\x03\xfe", "unknown kind"),
            (b"RIFF1234WAVE", "a text file"),
            (b"solid plate", "STL mesh"),
        ] {
            let message = complaint(bytes);
            assert!(message.starts_with("a.png: this is ") && message.contains(word), "{message}");
            assert!(message.contains("; "), "{message}");
        }
        assert!(complaint(b"").contains("empty"));
    }
}
