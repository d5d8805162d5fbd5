//! Routes of a program that contains the service, such as the demo. They are served beside those of the API.

use std::fmt;
use std::sync::Arc;

use utoipa_axum::router::OpenApiRouter;

use super::App;

/// Further routes with their descriptions. They pass the same checks as the API, and are in the OpenAPI document.
#[derive(Clone, Default)]
pub struct FurtherRoutes(Arc<OpenApiRouter<App>>);

impl FurtherRoutes {
    /// These routes. Each one that changes something must declare `x-required-role`.
    #[must_use]
    pub fn new(routes: OpenApiRouter<App>) -> Self {
        Self(Arc::new(routes))
    }

    pub(super) fn router(&self) -> OpenApiRouter<App> {
        self.0.as_ref().clone()
    }
}

impl fmt::Debug for FurtherRoutes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.0.get_openapi().paths.paths.keys()).finish()
    }
}
