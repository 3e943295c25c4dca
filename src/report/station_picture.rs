//! The station as a picture.
pub fn station_picture(_: &crate::station::Station, _: &crate::pattern::Pattern) -> String {
    String::new()
}
