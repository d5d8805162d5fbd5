// Schemas of the OpenAPI document as rows for people: name, type, meaning.

import { schema as named } from "./api.js";

/** Levels of nested fields that are listed. */
const DEPTH_MAX = 4;

/** A schema without references; texts beside a reference take the place of those behind it. */
function resolved(schema = {}) {
  const name = schema.$ref?.split("/").at(-1);
  if (!name) return schema;
  const { $ref: _, ...own } = schema;
  return { ...named(name), ...own };
}

/** The alternatives of a schema, without `null`. */
const alternatives = (schema) => (schema.oneOf ?? schema.anyOf ?? []).map(resolved).filter((one) => one.type !== "null");

/** The schema that holds the fields: an only alternative, or the schema itself. */
function plain(schema) {
  const told = resolved(schema);
  const [only, ...others] = alternatives(told);
  return only && !others.length ? { ...only, description: told.description ?? only.description } : told;
}

/** Type of a schema in words, for example "integer, 0 to 65535". */
export function typeOf(schema) {
  const told = plain(schema);
  const several = alternatives(told);
  if (several.length) return [...new Set(several.map(typeOf))].join(" or ");
  if (told.enum) return told.enum.map(String).join(", ");
  const types = [told.type ?? (told.properties || told.allOf ? "object" : "any")].flat();
  const type = types.filter((one) => one !== "null").join(" or ");
  if (type === "array") return `list of ${typeOf(told.items)}`;
  const limits =
    told.minimum !== undefined && told.maximum !== undefined
      ? `, ${told.minimum} to ${told.maximum}`
      : told.minimum !== undefined
        ? `, at least ${told.minimum}`
        : told.maximum !== undefined
          ? `, at most ${told.maximum}`
          : told.maxLength !== undefined
            ? `, at most ${told.maxLength} characters`
            : "";
  return (told.format === "date-time" ? "time (RFC 3339)" : type) + limits;
}

/** Fields of a schema and of the objects in it: `[{ name, type, description, isRequired }]`. */
export function fieldsOf(schema, prefix = "", depth = 0) {
  const told = plain(schema);
  if (told.type === "array") return fieldsOf(told.items, prefix && `${prefix}[]`, depth);
  const parts = told.allOf ? told.allOf.flatMap((one) => fieldsOf(one, prefix, depth)) : [];
  const required = told.required ?? [];
  const own = Object.entries(told.properties ?? {}).flatMap(([key, value]) => {
    const name = prefix ? `${prefix}.${key}` : key;
    const row = { name, type: typeOf(value), description: plain(value).description, isRequired: required.includes(key) };
    return [row, ...(depth < DEPTH_MAX ? fieldsOf(value, name, depth + 1) : [])];
  });
  return [...parts, ...own];
}
