// Keys and the switches that they turn.

import { element } from "./elements.ts";

/** Whether keys are meant for a field of the page, not for the view. */
export function isTyping({ target }: KeyboardEvent): boolean {
  const isText = target instanceof HTMLInputElement && !["checkbox", "range", "radio"].includes(target.type);
  return isText || target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}

/** Connects a switch, and the key that turns it, and applies it as it is. */
export function connectSwitch(id: string, key: string, apply: (on: boolean) => void): void {
  const box = element(id, HTMLInputElement);
  const update = () => apply(box.checked);
  box.addEventListener("input", update);
  box.addEventListener("change", () => box.blur());
  onKey(key, () => {
    if (box.disabled) return;
    box.checked = !box.checked;
    update();
  });
  update();
}

/** Calls `act` when a key is pressed that is meant for the view. */
export function onKey(code: string, act: () => void): void {
  window.addEventListener("keydown", (event) => {
    const isOurs = event.code === code && !event.repeat && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (!isOurs || isTyping(event)) return;
    event.preventDefault();
    act();
  });
}

/** The page is dark where the system is, and where the switch says so. */
export function connectDark(): void {
  element("dark", HTMLInputElement).checked = matchMedia("(prefers-color-scheme: dark)").matches;
  connectSwitch("dark", "KeyB", (isDark) => (document.documentElement.style.colorScheme = isDark ? "dark" : "light"));
}
