"""Prints the contacts of an archive as JSON. Times are numbers: us since 1970 UTC."""

import glob
import json
import sys

import duckdb

folder = sys.argv[1]
files = glob.glob(f"{folder}/**/*.parquet", recursive=True)
connection = duckdb.connect()
connection.sql("SET TimeZone = 'UTC'")
source = f"read_parquet('{folder}/**/*.parquet', hive_partitioning = true)"
rows = connection.sql(f"SELECT * FROM {source}")
types = dict(zip(rows.columns, [str(kind) for kind in rows.types]))
day = "datediff('day', DATE '1970-01-01', day) <> epoch_us(received_at) // 86400000000"
wrong = connection.sql(f"SELECT count(*) FROM {source} WHERE {day}").fetchall()[0][0]
columns = ["robot", "boot_id", "seq", "position", "array", "whisker", "ratio", "deflection_mm", "strain", "pressure_mpa"]
columns = ", ".join(f'"{name}"' for name in [*columns, "temperature_c"])
rows = connection.sql(f"SELECT {columns}, epoch_us(\"at\") AS \"at\" FROM {source}")
rows = [dict(zip(rows.columns, row)) for row in rows.fetchall()]
print(json.dumps({"types": types, "files": len(files), "wrong_days": wrong, "rows": rows}))
