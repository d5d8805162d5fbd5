//! Lists the migrations of both databases, which become part of the program. (sqlx's macro that reads them would build
//! the whole database library a second time.)

use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let migrations = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../migrations");
    let mut code = String::new();
    for database in ["sqlite", "postgres"] {
        let folder = migrations.join(database);
        println!("cargo::rerun-if-changed={}", folder.display());
        let files: io::Result<Vec<_>> = fs::read_dir(&folder)?.map(|file| Ok(file?.path())).collect();
        let mut files = files?;
        files.sort();
        code += &format!("/// Names and texts of the migrations in `migrations/{database}`.\n");
        code += &format!("pub(super) const {}: &[(&str, &str)] = &[\n", database.to_uppercase());
        for file in files {
            let name = file.file_stem().unwrap_or_default();
            code += &format!("    ({name:?}, include_str!({file:?})),\n");
        }
        code += "];\n";
    }
    let out = env::var("OUT_DIR").map_err(io::Error::other)?;
    fs::write(Path::new(&out).join("migrations.rs"), code)
}
