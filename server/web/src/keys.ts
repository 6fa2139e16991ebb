/** Whether keys are meant for a field of the page, not for the view. */
export function isTyping({ target }: KeyboardEvent): boolean {
  const isText = target instanceof HTMLInputElement && !["checkbox", "range", "radio"].includes(target.type);
  return isText || target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}
