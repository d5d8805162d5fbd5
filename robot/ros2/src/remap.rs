//! Names of ROS: expansion of relative and private names, and rules that replace them.

/// Names for which a rule counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Topic,
    Service,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Target {
    Namespace,
    Node,
    Name(Option<Kind>, String),
}

/// A rule `[node:]from:=to`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// Name of the node for which it counts; `None`: for each.
    node: Option<String>,
    target: Target,
    to: String,
}

/// Whether a text can be a part of a name between slashes.
fn is_token(token: &str) -> bool {
    let begins_well = token.starts_with(|letter: char| letter.is_ascii_alphabetic() || letter == '_');
    begins_well && !token.contains("__") && token.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// Whether a text is an absolute name.
fn is_full(name: &str) -> bool {
    name.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_token))
}

fn namespace(name: &str) -> Result<String, String> {
    if name == "/" || is_full(name) {
        return Ok(name.to_owned());
    }
    Err(format!("the namespace {name:?} is invalid: it begins with / and has letters, digits and single underscores"))
}

impl Rule {
    /// Reads a rule.
    ///
    /// # Errors
    /// The text is no rule; the error is a text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = |why: &str| format!("the rule {text:?} {why}");
        let (from, to) = text.split_once(":=").ok_or_else(|| wrong("has no `:=` between from and to"))?;
        if from.is_empty() || to.is_empty() {
            return Err(wrong("needs a name on both sides of `:=`"));
        }
        let is_scheme = from.starts_with("rostopic://") || from.starts_with("rosservice://");
        let (node, from) = match from.split_once(':') {
            Some((node, from)) if !is_scheme => (Some(node.to_owned()), from),
            _ => (None, from),
        };
        if node.as_deref().is_some_and(|node| !is_token(node)) {
            return Err(wrong("has an invalid name of a node"));
        }
        let target = match from {
            "__ns" => Target::Namespace,
            "__node" | "__name" => Target::Node,
            _ => {
                let (kind, name) = match (from.strip_prefix("rostopic://"), from.strip_prefix("rosservice://")) {
                    (Some(name), _) => (Some(Kind::Topic), name),
                    (_, Some(name)) => (Some(Kind::Service), name),
                    (None, None) => (None, from),
                };
                Target::Name(kind, name.to_owned())
            }
        };
        match &target {
            Target::Namespace => drop(namespace(to)?),
            Target::Node if !is_token(to) => return Err(wrong("gives the node an invalid name")),
            Target::Node => {}
            // The names of node and namespace are not known yet; any will do.
            Target::Name(_, from) => {
                for name in [from.as_str(), to] {
                    expand(name, "/", "node").map_err(|why| wrong(&format!("cannot be used: {why}")))?;
                }
            }
        }
        Ok(Self { node, target, to: to.to_owned() })
    }
}

/// The absolute name of a relative, private or absolute one.
fn expand(name: &str, namespace: &str, node: &str) -> Result<String, String> {
    let below = |namespace: &str, name: &str| format!("{}/{name}", namespace.trim_end_matches('/'));
    let inner = namespace.trim_end_matches('/');
    let replaced = name.replace("{node}", node).replace("{ns}", inner).replace("{namespace}", inner);
    let full = match replaced.strip_prefix('~') {
        Some("") => below(namespace, node),
        Some(rest) if rest.starts_with('/') => format!("{}{rest}", below(namespace, node)),
        None if !replaced.starts_with('/') => below(namespace, &replaced),
        _ => replaced,
    };
    if is_full(&full) {
        return Ok(full);
    }
    Err(format!("{name:?} is no name of ROS: it has letters, digits, single underscores and slashes"))
}

/// Name and namespace of the node, and the rules for the names that it uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    namespace: String,
    node: String,
    rules: Vec<Rule>,
}

impl Names {
    /// The names of a node, with its namespace and name unless a rule replaces them.
    ///
    /// # Errors
    /// The namespace is invalid.
    pub fn new(own_namespace: &str, own_node: &str, rules: Vec<Rule>) -> Result<Self, String> {
        let first = |target: &Target, node: &str| {
            let fits = |rule: &&Rule| rule.target == *target && rule.node.as_deref().is_none_or(|name| name == node);
            rules.iter().find(fits).map(|rule| rule.to.clone())
        };
        let node = first(&Target::Node, own_node).unwrap_or_else(|| own_node.to_owned());
        let namespace = namespace(&first(&Target::Namespace, &node).unwrap_or_else(|| own_namespace.to_owned()))?;
        Ok(Self { namespace, node, rules })
    }

    /// The namespace, such as `/crawler`.
    #[must_use]
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// The name of the node.
    #[must_use]
    pub fn node(&self) -> &str {
        &self.node
    }

    /// The absolute name of the node.
    #[must_use]
    pub fn full(&self) -> String {
        format!("{}/{}", self.namespace.trim_end_matches('/'), self.node)
    }

    /// The absolute name of a topic, after the rules.
    ///
    /// # Errors
    /// The name is invalid.
    pub fn topic(&self, name: &str) -> Result<String, String> {
        self.resolve(Kind::Topic, name)
    }

    /// The absolute name of a service or an action, after the rules.
    ///
    /// # Errors
    /// The name is invalid.
    pub fn service(&self, name: &str) -> Result<String, String> {
        self.resolve(Kind::Service, name)
    }

    fn resolve(&self, kind: Kind, name: &str) -> Result<String, String> {
        let expand = |name: &str| expand(name, &self.namespace, &self.node);
        let full = expand(name)?;
        let replaces = |rule: &&Rule| {
            let Target::Name(only, from) = &rule.target else { return false };
            let is_here = rule.node.as_deref().is_none_or(|node| node == self.node);
            is_here && only.is_none_or(|only| only == kind) && expand(from).is_ok_and(|from| from == full)
        };
        self.rules.iter().find(replaces).map_or(Ok(full.clone()), |rule| expand(&rule.to))
    }
}
