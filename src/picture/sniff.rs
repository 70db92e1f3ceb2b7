//! What a file is, by its first bytes.

use image::ImageFormat;

use super::PictureError;

/// This many bytes are enough to tell.
pub(crate) const ENOUGH: u64 = 4096;

const EXPORT: &str = "export it as PNG";
const DRAWING: &str = "export it as PNG, 1000 pixels wide or more";

/// Beginnings of what people mistake for a picture that is read: offset, bytes, what it is, what would do.
const OTHERS: [(usize, &[u8], &str, &str); 23] = [
    (0, b"GIF8", "a GIF picture", EXPORT),
    (0, b"BM", "a BMP picture", EXPORT),
    (0, b"%PDF", "a PDF document", DRAWING),
    (0, b"%!PS", "a PostScript document", DRAWING),
    (0, b"8BPS", "a Photoshop document", EXPORT),
    (0, b"gimp xcf", "a GIMP document", EXPORT),
    (0, b"\x76\x2f\x31\x01", "an OpenEXR picture", "export it as 16-bit PNG or float TIFF"),
    (0, b"#?R", "a Radiance HDR picture", "export it as 16-bit PNG or float TIFF"),
    (0, b"\0\0\x01\0", "an icon", EXPORT),
    (4, b"ftypavif", "an AVIF picture", EXPORT),
    (4, b"ftyphei", "a HEIC photograph", "export it as JPEG or PNG"),
    (4, b"ftypmif1", "a HEIC photograph", "export it as JPEG or PNG"),
    (4, b"ftyp", "a film or a rare kind of picture", EXPORT),
    (0, b"\0\0\0\x0cJXL ", "a JPEG XL picture", EXPORT),
    (0, b"\xff\x0a", "a JPEG XL picture", EXPORT),
    (0, b"\0\0\0\x0cjP  ", "a JPEG 2000 picture", EXPORT),
    (0, b"\xff\x4f\xff\x51", "a JPEG 2000 picture", EXPORT),
    (0, b"qoif", "a QOI picture", EXPORT),
    (0, b"DDS ", "a DDS texture", EXPORT),
    (0, b"PK\x03\x04", "a zip archive or a document packed as one", "take the picture out of it as PNG"),
    (0, b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (0, b"solid ", "an STL mesh", "give the drawing of the highlight"),
    (0, b"\x93NUMPY", "a NumPy array", "save it as 16-bit PNG or float TIFF"),
];

/// The format of a file that begins with `bytes`, one of the four that are read.
pub fn format(bytes: &[u8], name: &str) -> Result<ImageFormat, PictureError> {
    if bytes.is_empty() {
        return Err(PictureError::Empty { name: name.into() });
    }
    // BigTIFF is decoded like TIFF but begins otherwise.
    if bytes.starts_with(b"II\x2b\0") || bytes.starts_with(b"MM\0\x2b") {
        return Ok(ImageFormat::Tiff);
    }
    match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Tiff | ImageFormat::WebP)) => Ok(format),
        _ => {
            let (found, remedy) = describe(bytes);
            Err(PictureError::Format { name: name.into(), found, remedy })
        }
    }
}

/// The format's name as people write it.
pub fn title(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Tiff => "TIFF",
        _ => "WebP",
    }
}

/// What bytes of no readable format look like, and what would do.
fn describe(bytes: &[u8]) -> (&'static str, &'static str) {
    let head = &bytes[..bytes.len().min(ENOUGH as usize)];
    let begins = |at: usize, mark: &[u8]| head.get(at..).is_some_and(|rest| rest.starts_with(mark));
    if let Some((_, _, found, remedy)) = OTHERS.iter().find(|(at, mark, ..)| begins(*at, mark)) {
        return (found, remedy);
    }
    if head.iter().all(|b| *b == 0) {
        return ("nothing but zero bytes", "save or download the picture again");
    }
    // A character cut in two at the end of the head is still text.
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(e) if e.error_len().is_none() => std::str::from_utf8(&head[..e.valid_up_to()]).unwrap_or(""),
        Err(_) => "",
    };
    let lower = text.to_ascii_lowercase();
    if lower.contains("<svg") {
        ("an SVG drawing", DRAWING)
    } else if lower.contains("<html") || lower.contains("<!doctype html") {
        ("a web page", "download the picture itself")
    } else if is_netpbm(head) {
        ("a PBM, PGM or PPM picture", EXPORT)
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
        assert_eq!(format(b"\x89PNG\r\n\x1a\n", "a.jpg").unwrap(), ImageFormat::Png);
        assert_eq!(format(b"\xff\xd8\xff\xe0", "a.png").unwrap(), ImageFormat::Jpeg);
        assert_eq!(format(b"II*\0", "").unwrap(), ImageFormat::Tiff);
        assert_eq!(format(b"MM\0\x2b", "").unwrap(), ImageFormat::Tiff);
        assert_eq!(format(b"RIFF1234WEBPVP8 ", "").unwrap(), ImageFormat::WebP);
        for (bytes, word) in [
            (&b"GIF89a\x01\0\x01\0"[..], "GIF"),
            (b"<?xml version='1.0'?>\n<SVG xmlns=''>", "SVG"),
            (b"%PDF-1.7", "PDF"),
            (b"P5 2 2 255\n1234", "PGM"),
            (b"P5", "text"),
            (b"<!DOCTYPE html><html>", "web page"),
            ("Grüße, 漢".as_bytes(), "a text file"),
            (&"漢".as_bytes()[..2], "unknown kind"),
            (b"\0\0\0\x20ftypheic", "HEIC"),
            (b"\0\0\0\0\0\0", "zero bytes"),
            (b"\x01\x02\x03\xfe", "unknown kind"),
            (b"RIFF1234WAVE", "a text file"),
        ] {
            let message = complaint(bytes);
            assert!(message.starts_with("a.png: this is ") && message.contains(word), "{message}");
            assert!(message.contains("; "), "{message}");
        }
        assert!(complaint(b"").contains("empty"));
    }
}
