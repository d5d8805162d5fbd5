"""Prints the content of an exported file as JSON. Times are numbers: µs since 1970 UTC."""

import json
import sys

import duckdb
from mcap.reader import make_reader


def table(relation):
    connection = duckdb.connect()
    connection.sql("SET TimeZone = 'UTC'")
    rows = connection.sql(f"SELECT * FROM {relation}")
    types = dict(zip(rows.columns, [str(kind) for kind in rows.types]))
    times = [name for name, kind in types.items() if kind.startswith("TIMESTAMP")]
    shown = [f'epoch_us("{name}") AS "{name}"' if name in times else f'"{name}"' for name in rows.columns]
    rows = connection.sql(f"SELECT {', '.join(shown)} FROM {relation}")
    return {"types": types, "rows": [dict(zip(rows.columns, row)) for row in rows.fetchall()]}


def messages(path):
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        return [
            {
                "topic": channel.topic,
                "encoding": channel.message_encoding,
                "schema": schema and {"name": schema.name, "encoding": schema.encoding, "title": json.loads(schema.data).get("title")},
                "time_ns": message.log_time,
                "data": json.loads(message.data),
            }
            for schema, channel, message in reader.iter_messages()
        ]


path = sys.argv[1]
if path.endswith(".mcap"):
    print(json.dumps(messages(path)))
elif path.endswith(".parquet"):
    print(json.dumps(table(f"'{path}'")))
else:
    # Without BOOLEAN: a fleet may be called f.
    kinds = "['BIGINT', 'DOUBLE', 'TIMESTAMPTZ', 'VARCHAR']"
    print(json.dumps(table(f"read_csv('{path}', header = true, sample_size = -1, auto_type_candidates = {kinds})")))
