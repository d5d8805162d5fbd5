//! Pagination of lists: limit, cursor, order.

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::problem::Problem;
use vibrissa_store::list::{Position, Rows, Selection, Sort};

/// Default number of rows per page.
pub const LIMIT: u32 = 100;
/// Maximum number of rows per page.
pub const LIMIT_MAX: u32 = 1000;

/// A page of a list.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Page<T> {
    /// Rows of the page.
    pub items: Vec<T>,
    /// `cursor` of the next page; null on the last page.
    #[schema(max_length = 1000, pattern = "^eyJzb3J0Ijoi[A-Za-z0-9_-]+$")]
    pub next_cursor: Option<String>,
}

/// Sort order of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Smallest value first.
    Ascending,
    /// Largest value first.
    Descending,
}

/// Pagination parameters of a request.
#[derive(Debug)]
pub struct Paging<'a> {
    /// Maximum number of rows.
    pub limit: Option<u32>,
    /// `next_cursor` of the previous page.
    pub cursor: Option<&'a str>,
    /// Column by which the list is sorted.
    pub sort: Sort,
    /// Sort order; by default that of the sort column.
    pub order: Option<Order>,
}

/// End of a page in a given order. In base64, each cursor begins with `eyJzb3J0Ijoi`, which is `{"sort":"`.
#[derive(Debug, Serialize, Deserialize)]
struct Cursor {
    sort: String,
    descending: bool,
    /// Clients hold cursors with this name.
    #[serde(rename = "place")]
    position: Position,
}

impl Paging<'_> {
    /// The database query for this page, without filters.
    ///
    /// # Errors
    /// The limit is out of range, or the cursor belongs to another list or order.
    pub fn selection(&self) -> Result<Selection, Problem> {
        let limit = self.limit.unwrap_or(LIMIT);
        if !(1..=LIMIT_MAX).contains(&limit) {
            return Err(Problem::invalid("limit", format!("must be 1 to {LIMIT_MAX}, not {limit}")));
        }
        let descending = self.order.map_or(self.sort.descending, |order| order == Order::Descending);
        let after = self.cursor.filter(|cursor| !cursor.is_empty());
        let after = after.map(|cursor| position(cursor, self.sort, descending)).transpose()?;
        Ok(Selection { filters: Vec::new(), sort: self.sort, descending, after, limit })
    }
}

fn position(cursor: &str, sort: Sort, descending: bool) -> Result<Position, Problem> {
    let read = URL_SAFE_NO_PAD.decode(cursor).ok();
    let read = read.and_then(|bytes| serde_json::from_slice::<Cursor>(&bytes).ok());
    if read.as_ref().is_some_and(|cursor| cursor.position.value.has_nul() || cursor.sort.contains('\0')) {
        return Err(Problem::nul("cursor"));
    }
    let read = read.filter(|cursor| cursor.sort == sort.column && cursor.descending == descending);
    read.filter(|cursor| cursor.position.value.is_a(sort.kind)).map(|cursor| cursor.position).ok_or_else(|| {
        Problem::invalid("cursor", "belongs to another list or order: use next_cursor of the previous page unchanged")
    })
}

impl<T> Page<T> {
    /// The same page with other rows.
    #[must_use]
    pub fn map<U>(self, with: impl FnMut(T) -> U) -> Page<U> {
        Page { items: self.items.into_iter().map(with).collect(), next_cursor: self.next_cursor }
    }

    /// Builds a page from these rows.
    #[must_use]
    pub fn of(rows: Rows<T>, selection: &Selection) -> Self {
        let next_cursor = rows.next.and_then(|position| {
            let cursor = Cursor { sort: selection.sort.column.to_owned(), descending: selection.descending, position };
            serde_json::to_vec(&cursor).ok()
        });
        Self { items: rows.rows, next_cursor: next_cursor.map(|json| URL_SAFE_NO_PAD.encode(json)) }
    }
}

/// Query parameters of a list: its own filters and the pagination parameters.
macro_rules! list_query {
    ($(#[$meta:meta])* pub struct $name:ident by $sort:ty { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Debug, serde::Deserialize, utoipa::IntoParams)]
        #[into_params(parameter_in = Query)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $type,)*
            /// Maximum number of rows per page. CSV without a limit has all rows from the cursor on.
            #[param(minimum = 1, maximum = 1000, default = 100)]
            pub limit: Option<u32>,
            /// `next_cursor` of the previous page; omit it for the first page.
            #[param(max_length = 1000, pattern = "^(eyJzb3J0Ijoi[A-Za-z0-9_-]+)?$")]
            pub cursor: Option<String>,
            /// Column by which the list is sorted.
            #[param(inline)]
            pub sort: Option<$sort>,
            /// Order of the list; by default that of the sort column.
            #[param(inline)]
            pub order: Option<$crate::http::page::Order>,
            /// Format of the answer; by default that of the header `Accept`, and else JSON.
            #[param(inline)]
            pub format: Option<$crate::http::words::FormatWord>,
        }

        impl $name {
            /// The query for this page, without filters.
            ///
            /// # Errors
            /// The limit or the cursor is invalid.
            pub fn page(&self) -> Result<vibrissa_store::list::Selection, $crate::http::problem::Problem> {
                let sort = self.sort.map_or(<$sort>::SORTS[0], <$sort>::sort);
                let (limit, cursor, order) = (self.limit, self.cursor.as_deref(), self.order);
                $crate::http::page::Paging { limit, cursor, sort, order }.selection()
            }
        }
    };
}
pub(super) use list_query;
