"use strict";
// Tables are sorted by a click on a head, and copied by a button. Without this, the page only lacks both.
for (const table of document.querySelectorAll("table")) {
  const [heads, body] = [table.tHead.rows[0].cells, table.tBodies[0]];
  const text = (row, column) => row.cells[column].textContent.trim();
  // "1,234 ± 5 s" is 1234; a text without a number at its beginning is none.
  const number = (text) => {
    const digits = /^[-+]?\d[\d,]*(\.\d+)?/.exec(text);
    return digits ? Number(digits[0].replaceAll(",", "")) : NaN;
  };
  const compare = (a, b) => {
    const [x, y] = [number(a), number(b)];
    if (Number.isNaN(x) && Number.isNaN(y)) return a.localeCompare(b);
    return Number.isNaN(x) ? 1 : Number.isNaN(y) ? -1 : x - y;
  };
  for (const [column, head] of [...heads].entries()) {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.onclick = () => {
      const order = head.ariaSort === "ascending" ? "descending" : "ascending";
      for (const other of heads) other.ariaSort = null;
      head.ariaSort = order;
      const sign = order === "ascending" ? 1 : -1;
      const rows = [...body.rows];
      rows.sort((a, b) => sign * compare(text(a, column), text(b, column)));
      body.append(...rows);
    };
  }
  const copy = document.createElement("button");
  copy.className = "copy";
  copy.textContent = "Copy table";
  copy.onclick = () => {
    // The selection takes the table along as cells; it works for files, too.
    getSelection().selectAllChildren(table);
    document.execCommand("copy");
    getSelection().removeAllRanges();
    copy.textContent = "Copied";
  };
  table.after(copy);
}
