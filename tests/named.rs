//! What `symbols.rs` finds absent has these names: a program with scenes that ask for it has each of them.

use crate::names::{UNASKED, has, own_file};

#[test]
fn what_is_named_is_there() {
    let file = own_file();
    for present in UNASKED {
        assert!(has(&file, present), "{present}, read backwards, is no name of what this program has");
    }
}
