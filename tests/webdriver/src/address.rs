//! URLs of files.

use std::path::Path;

/// The URL of a file, whatever characters its name has.
pub fn url(path: &Path) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-_.".contains(&byte);
    let path = path.as_os_str().as_encoded_bytes().iter();
    let escaped = path.map(|&byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") });
    format!("file://{}", escaped.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::url;
    use std::path::Path;

    #[test]
    fn what_means_something_in_an_address_is_escaped() {
        assert_eq!(url(Path::new("/tmp/.a-b_c/1.html")), "file:///tmp/.a-b_c/1.html");
        assert_eq!(url(Path::new("/a b?#%.ä")), "file:///a%20b%3F%23%25.%C3%A4");
    }
}
