// Reads the readings of a calibration from a CSV file, as `vibrissa-lab calibrate` does, or from JSON in the form of the API.

/** Columns of strain with their factor, and whether the gauge factor divides them. */
const STRAINS = {
  strain: [1, false],
  strain_reading_um_per_m: [1e-6, true],
  strain_reading_mm_per_m: [1e-3, true],
};
const PRESSURE = "pressure_mpa";
const ELONGATION = "elongation_mm";
const KNOWN = [PRESSURE, ...Object.keys(STRAINS), ELONGATION];

/** A cause in plain words, with its line. */
export class Unreadable extends Error {}

/** The text of a file in UTF-8, or in UTF-16 with a byte order mark. */
export async function textOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const mark = `${bytes[0]},${bytes[1]}`;
  const encoding = { "255,254": "utf-16le", "254,255": "utf-16be" }[mark] ?? "utf-8";
  if (encoding === "utf-8" && bytes.includes(0))
    throw new Unreadable("The file seems to be in UTF-16 without a byte order mark: save it as CSV in UTF-8.");
  try {
    return new TextDecoder(encoding, { fatal: true }).decode(bytes);
  } catch {
    throw new Unreadable("The file is not text in UTF-8: save it as CSV in UTF-8.");
  }
}

/** `{ rows, lines }`: rows for the API, and the line of the file from which each comes (null for JSON). */
export function readings(text, gaugeFactor) {
  if (text.trimStart().startsWith("{")) return { rows: fromJson(text), lines: null };
  const lines = text
    .replace(/^\ufeff/, "")
    .split(/\r\n|\n|\r/)
    .map((line, index) => [index + 1, line])
    .filter(([, line]) => !line.startsWith("#") && !/^sep=,?\s*$/i.test(line) && cells(line).some((cell) => cell));
  if (lines.length < 2)
    throw new Unreadable(
      `The table has no rows below its header: write a header such as ${PRESSURE},strain and below it one line for each reading, such as 0.05,0.0146.`,
    );
  const [[, header], ...rest] = lines;
  const columns = columnsOf(header);
  return { rows: rest.map(([line, row]) => rowOf(row, columns, gaugeFactor, line)), lines: rest.map(([line]) => line) };
}

function fromJson(text) {
  let told;
  try {
    told = JSON.parse(text);
  } catch (problem) {
    throw new Unreadable(`The file is not valid JSON: ${problem.message}.`);
  }
  if (!Array.isArray(told.rows)) throw new Unreadable('The file has no list "rows", as the API expects it.');
  return told.rows;
}

function columnsOf(header) {
  for (const [separator, name] of [
    [";", "semicolons"],
    ["\t", "tabs"],
  ])
    if (header.includes(separator))
      throw new Unreadable(
        `Its columns are separated by ${name}: separate them by commas, and write numbers with a decimal point, such as 0.05.`,
      );
  const columns = cells(header);
  for (const column of columns.filter((column) => column)) {
    if (!KNOWN.includes(column)) {
      const hint = /kpa/i.test(column) ? ` Write pressures in MPa into ${PRESSURE}: 100 kPa are 0.1 MPa.` : "";
      throw new Unreadable(`Unknown column "${column}"; known are ${KNOWN.join(", ")}.${hint}`);
    }
    if (columns.filter((other) => other === column).length > 1) throw new Unreadable(`Column ${column} appears twice.`);
  }
  if (!columns.includes(PRESSURE)) throw new Unreadable(`Missing column ${PRESSURE}.`);
  if (columns.filter((column) => column in STRAINS).length !== 1)
    throw new Unreadable(`Exactly one of the columns ${Object.keys(STRAINS).join(", ")} is required.`);
  return columns;
}

const cells = (line) => line.split(",").map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));

function rowOf(text, columns, gaugeFactor, line) {
  const told = cells(text);
  const named = columns.findLastIndex((column) => column) + 1;
  if (told.length < named || told.some((cell, index) => cell && !columns[index]))
    throw new Unreadable(
      `Line ${line}: ${told.length} cells, but the header has ${named} columns: write a number in each column, leave cells without a reading empty, and write numbers with a decimal point.`,
    );
  const row = {};
  columns.forEach((column, index) => {
    if (!column || told[index] === "") return;
    const number = Number(told[index]);
    if (!Number.isFinite(number)) throw new Unreadable(`Line ${line}, column ${column}: "${told[index]}" is not a number.`);
    if (column in STRAINS) {
      const [factor, isReading] = STRAINS[column];
      row.strain = number * (isReading ? factor / gaugeFactor : factor);
    } else row[column] = number;
  });
  const pressure = row[PRESSURE];
  if (pressure === undefined) throw new Unreadable(`Line ${line}, column ${PRESSURE}: empty cell.`);
  if (pressure >= 1 && pressure <= 1000)
    throw new Unreadable(
      `Line ${line}: a pressure of ${pressure} MPa is too high; if it is in kPa, write ${pressure / 1000} MPa.`,
    );
  return row;
}
