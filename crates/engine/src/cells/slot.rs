//! Slots: the index of a body or a cell in one word, together with the image in which it is seen.

/// Bits of a body's index in a slot or a partner; the other bits hold the kind of event, or the
/// image.
pub(super) const INDEX_BITS: u32 = 28;
/// Mask of an index.
pub(super) const INDEX_MASK: u32 = (1 << INDEX_BITS) - 1;

/// Wraps a cell index that is at most one outside its range, and returns the periodic image in
/// which the cell is seen (boxes).
#[doc(alias = "minimum image")]
pub(super) fn wrap_cell(index: i32, count: i32) -> (i32, i32) {
    let image = i32::from(index >= count) - i32::from(index < 0);
    (index - image * count, image)
}

/// Code of an image along an axis: 0 for none, 1 for one box up, 2 for one box down.
pub(super) fn image_code(image: i32) -> u32 {
    (image & 3) as u32 & if image < 0 { 2 } else { 1 }
}

/// The image in which a slot's disc is seen, in boxes.
pub(super) fn image_of(slot: u32) -> [i32; 2] {
    let decode = |code: u32| (code & 1) as i32 - (code >> 1 & 1) as i32;
    [decode(slot >> INDEX_BITS), decode(slot >> (INDEX_BITS + 2))]
}
