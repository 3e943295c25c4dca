// Building blocks of pages. Texts are inserted as text, never as HTML: names and ids may
// contain anything. Every figure is a <data> element: rounded for people, with its exact value
// in the attribute.

const byName = (id) => document.getElementById(id);

function element(name, content, className) {
  const made = document.createElement(name);
  made.append(...(Array.isArray(content) ? content : [content]));
  if (className) made.className = className;
  return made;
}

/** `value` x `factor` with `digits` decimals; the element's `value` is exact. */
function figure(name, value, digits, factor = 1) {
  const data = element("data", (factor * value).toFixed(digits));
  data.value = String(value);
  data.dataset.name = name;
  return data;
}

/** Puts figures with their names into a <dl>. */
function fillList(list, rows) {
  const row = ([name, value]) => element("div", [element("dt", name), element("dd", value)]);
  list.replaceChildren(...rows.map(row));
}

function fillTable(table, header, rows) {
  const head = header.map((name) => {
    const cell = element("th", name);
    cell.scope = "col";
    return cell;
  });
  const body = rows.map((cells) => element("tr", cells.map((cell) => element("td", cell))));
  table.replaceChildren(element("thead", element("tr", head)), element("tbody", body));
}

/** Puts `lines` into `element`. */
function tell(element, lines) {
  element.replaceChildren(
    ...lines.map((words, i) => {
      const line = document.createElement("p");
      line.textContent = words;
      if (i === 0) line.className = "head";
      return line;
    }),
  );
}

/** Puts `box` beside the pointer, and inside the window. */
function placeBeside(box, { x, y }) {
  const left = x + 16 + box.offsetWidth > window.innerWidth ? x - 16 - box.offsetWidth : x + 16;
  const top = Math.min(y + 12, window.innerHeight - box.offsetHeight - 8);
  box.style.left = `${Math.max(8, left)}px`;
  box.style.top = `${Math.max(8, top)}px`;
}
