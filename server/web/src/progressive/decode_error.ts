// What is said of bytes that are no tile and no model.

/** Bytes that are not what they are taken for. */
export class DecodeError extends Error {
  override readonly name = "DecodeError";
}

export function check(condition: boolean, message: string): asserts condition {
  if (!condition) throw new DecodeError(message);
}
