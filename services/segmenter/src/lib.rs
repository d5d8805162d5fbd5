//! Contacts from the strain of a whisker.
