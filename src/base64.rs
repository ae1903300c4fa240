//! Bytes as letters: the base64 of RFC 4648.

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

pub(crate) fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(4 * bytes.len().div_ceil(3));
    for three in bytes.chunks(3) {
        let byte = |i: usize| three.get(i).map_or(0, |&byte| u32::from(byte) << (16 - 8 * i));
        let bits = byte(0) | byte(1) | byte(2);
        let letter = |i: usize| char::from(LETTERS[(bits >> (18 - 6 * i)) as usize % 64]);
        text.extend((0..4).map(|i| if i <= three.len() { letter(i) } else { '=' }));
    }
    text
}
