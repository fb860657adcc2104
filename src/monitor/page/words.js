// Formats numbers and sentences, and fills tables.

export const at = (id) => document.getElementById(id);

// Formats a number with `digits` decimals, a real minus sign, and no minus zero.
export function fixed(x, digits) {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  const text = x.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

// Formats a number with `digits` significant digits, without a power of ten.
export const figures = (x, digits) => fixed(x, Math.min(6, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(x) || 1)))));

export function sentence(text, capital = true) {
  const first = capital ? text.charAt(0).toUpperCase() : text.charAt(0);
  return first + text.slice(1) + (text.endsWith(".") ? "" : ".");
}

// Fills a table with rows of cells, which are texts or elements; with `head` the first row is its head. Changes only the cells that differ.
export function fillTable(table, rows, head = true) {
  while (table.rows.length > rows.length) table.deleteRow(-1);
  rows.forEach((row, i) => {
    const line = table.rows[i] ?? table.insertRow();
    if (line.className !== (row.kind ?? "")) line.className = row.kind ?? "";
    while (line.cells.length > row.length) line.deleteCell(-1);
    const kind = head && i === 0 ? "th" : "td";
    row.forEach((content, k) => fillCell(line.cells[k] ?? line.appendChild(document.createElement(kind)), content));
  });
}

function fillCell(cell, content) {
  if (content instanceof Node) {
    if (!cell.firstElementChild?.isEqualNode(content)) cell.replaceChildren(content);
  } else if (cell.childElementCount || cell.textContent !== content) cell.textContent = content;
}
