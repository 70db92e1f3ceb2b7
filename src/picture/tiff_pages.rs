//! The pages of a TIFF file: how large each is, what it is said to be, and which of them is the picture.
//!
//! The directories are walked here, since the crate `tiff` gives up at a page that it cannot decode, and previews,
//! thumbnails and camera data are just such pages or stand beside them.

/// The most pages that are looked at.
const MOST: usize = 1000;

/// The most entries of a directory that are looked at; real ones have some dozens.
const ENTRIES: u64 = 4096;

/// What a directory says of its page.
#[derive(Clone, Debug, Default)]
pub(crate) struct Page {
    /// Where its directory stands.
    pub offset: u64,
    /// Columns and rows.
    pub size: (u64, u64),
    /// Tag 254, bit 0, or tag 255: a smaller copy of another page.
    pub reduced: bool,
    /// Tag 254, bit 2: which parts of another page are to be seen.
    pub mask: bool,
    /// Tag 262: what its numbers stand for.
    pub photometric: Option<u64>,
    /// Where in the file that number stands, and in how many bytes.
    pub photometric_at: (u64, usize),
    /// Tag 50706 or 33421: numbers of a camera's sensor, or a picture that goes with them.
    pub camera: bool,
    /// Where the directories of the pages within it stand (tag 330).
    inner: Vec<u64>,
}

/// TIFF 6.0, or the variant with offsets of 64 bits.
pub(crate) struct Layout<'a> {
    bytes: &'a [u8],
    big_endian: bool,
    /// Offsets of 64 bits.
    pub wide: bool,
}

impl<'a> Layout<'a> {
    /// `None`: this is no TIFF.
    pub(crate) fn new(bytes: &'a [u8]) -> Option<Self> {
        let big_endian = match bytes.get(..2)? {
            b"II" => false,
            b"MM" => true,
            _ => return None,
        };
        let mut layout = Self { bytes, big_endian, wide: false };
        match layout.number(2, 2)? {
            42 => {}
            43 => layout.wide = true,
            _ => return None,
        }
        Some(layout)
    }

    /// The number of `size` bytes at `at`.
    fn number(&self, at: u64, size: usize) -> Option<u64> {
        let from = usize::try_from(at).ok()?;
        let bytes = self.bytes.get(from..from.checked_add(size)?)?;
        let push = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if self.big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) })
    }

    /// `offset` as it would stand in the header, and where it stands there.
    pub(crate) fn first(&self, offset: u64) -> (usize, Vec<u8>) {
        let (at, size) = if self.wide { (8, 8) } else { (4, 4) };
        (at, self.encoded(offset, size))
    }

    /// `value` in `size` bytes.
    pub(crate) fn encoded(&self, value: u64, size: usize) -> Vec<u8> {
        let bytes = value.to_le_bytes()[..size].to_vec();
        if self.big_endian { bytes.into_iter().rev().collect() } else { bytes }
    }

    /// All pages in the order of the file, those within a page behind it.
    pub(crate) fn pages(&self) -> Vec<Page> {
        let mut pages: Vec<Page> = Vec::new();
        let mut next = self.number(if self.wide { 8 } else { 4 }, if self.wide { 8 } else { 4 });
        while let Some(offset) = next.filter(|offset| *offset > 0 && pages.len() < MOST) {
            // A chain of pages that runs in a circle is as long as its circle.
            if pages.iter().any(|page| page.offset == offset) {
                break;
            }
            let Some((page, following)) = self.page(offset) else { break };
            let inner = page.inner.clone();
            pages.push(page);
            pages.extend(inner.into_iter().take(16).filter_map(|offset| Some(self.page(offset)?.0)));
            next = following;
        }
        pages
    }

    /// The page whose directory stands at `offset`, and where the next one stands.
    fn page(&self, offset: u64) -> Option<(Page, Option<u64>)> {
        let (count_size, entry_size, offset_size) = if self.wide { (8, 20, 8) } else { (2, 12, 4) };
        let entries = self.number(offset, count_size)?;
        if entries > ENTRIES {
            return None;
        }
        let mut page = Page { offset, ..Page::default() };
        let first = offset.checked_add(count_size as u64)?;
        for entry in 0..entries {
            let at = first.checked_add(entry * entry_size)?;
            let (tag, kind) = (self.number(at, 2)?, self.number(at + 2, 2)?);
            let count = self.number(at + 4, offset_size)?;
            let value_at = at + 4 + offset_size as u64;
            let size = match kind {
                1 | 6 => 1,
                3 => 2,
                4 | 13 => 4,
                16 | 18 => 8,
                // Text, fractions and floats say nothing that is wanted here.
                _ => 0,
            };
            let value = || if size == 0 || size > offset_size { None } else { self.number(value_at, size) };
            match tag {
                254 => {
                    let bits = value().unwrap_or(0);
                    page.reduced |= bits & 1 != 0;
                    page.mask |= bits & 4 != 0;
                }
                255 => page.reduced |= value() == Some(2),
                256 => page.size.0 = value().unwrap_or(0),
                257 => page.size.1 = value().unwrap_or(0),
                262 => (page.photometric, page.photometric_at) = (value(), (value_at, size)),
                330 => page.inner = self.offsets(value_at, size, count, offset_size),
                33_421 | 50_706 => page.camera = true,
                _ => {}
            }
        }
        // Sensors: a mosaic of colour filters, or three linear colours made of one.
        page.camera |= matches!(page.photometric, Some(32_803 | 34_892));
        Some((page, self.number(first + entries * entry_size, offset_size)))
    }

    /// Up to 16 offsets of a tag: in its entry if they have room there, else where the entry says.
    fn offsets(&self, value_at: u64, size: usize, count: u64, room: usize) -> Vec<u64> {
        if size < 4 {
            return Vec::new();
        }
        let within = count.saturating_mul(size as u64) <= room as u64;
        let Some(from) = (if within { Some(value_at) } else { self.number(value_at, room) }) else { return Vec::new() };
        (0..count.min(16)).map_while(|k| self.number(from.checked_add(k * size as u64)?, size)).collect()
    }
}

/// The index of the picture among `pages`: the first page that is neither a smaller copy nor a mask, unless a later
/// page of the same proportions is larger: then the first was a preview.
pub(crate) fn picture(pages: &[Page]) -> usize {
    let whole = |page: &&(usize, &Page)| !page.1.reduced && !page.1.mask && page.1.size.0 > 0 && page.1.size.1 > 0;
    let numbered: Vec<(usize, &Page)> = pages.iter().enumerate().collect();
    let Some(&(first, page)) = numbered.iter().find(whole) else { return 0 };
    let proportion = |page: &Page| page.size.0 as f64 / page.size.1 as f64;
    // A thumbnail's sides are rounded to whole pixels.
    let same = |other: &Page| {
        let short = page.size.0.min(page.size.1).max(1) as f64;
        (proportion(other) / proportion(page) - 1.0).abs() < 0.01 + 1.0 / short
    };
    let larger = |(_, other): &&(usize, &Page)| other.size.0 > page.size.0 && same(other);
    let area = |entry: &&(usize, &Page)| entry.1.size.0.saturating_mul(entry.1.size.1);
    // The first of the largest.
    numbered.iter().filter(whole).filter(larger).rev().max_by_key(area).map_or(first, |entry| entry.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(width: u64, height: u64, reduced: bool) -> Page {
        Page { size: (width, height), reduced, ..Page::default() }
    }

    #[test]
    fn the_picture_is_the_first_page_that_is_no_preview_of_another() {
        for (pages, wanted) in [
            (vec![page(9, 9, false)], 0),
            (vec![page(32, 32, true), page(256, 256, false)], 1),
            // A preview that does not say what it is.
            (vec![page(32, 32, false), page(256, 256, false), page(128, 128, false)], 1),
            (vec![page(33, 17, false), page(400, 200, false)], 1),
            // Pages of a document, and frames of a film: the first.
            (vec![page(100, 140, false), page(200, 140, false)], 0),
            (vec![page(64, 64, false); 3], 0),
            // Nothing but copies: what there is.
            (vec![page(32, 32, true)], 0),
            (vec![Page { mask: true, ..page(64, 64, false) }, page(64, 64, false)], 1),
            (vec![page(0, 0, false), page(4, 4, false)], 1),
            (vec![], 0),
        ] {
            assert_eq!(picture(&pages), wanted, "{pages:?}");
        }
    }
}
