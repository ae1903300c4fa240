//! Names in the file of a program, which tell what code it has.

/// What a program may be made of, as paths told backwards, so that they do not count where they are asked for: pairs,
/// tiles of pairs, random numbers, thermostats, a magnetic field, and the sines of random angles.
pub(crate) const UNASKED: [&str; 7] = [
    "sriap_neewteb", "secrof_dda::selit", "xolihp", "nivegnal", "nesredna", "citengam", "socnis::htam::mbil",
];

/// The file of this program, as text.
pub(crate) fn own_file() -> String {
    let file = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    String::from_utf8_lossy(&file).into_owned()
}

/// Whether a file has this path, told backwards: names of functions have each part after its length, or between dots.
pub(crate) fn has(file: &str, backwards: &str) -> bool {
    let path: String = backwards.chars().rev().collect();
    let long: String = path.split("::").map(|part| format!("{}{part}", part.len())).collect();
    file.contains(&long) || file.contains(&format!("..{}..", path.replace("::", "..")))
}
