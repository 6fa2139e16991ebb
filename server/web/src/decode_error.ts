// What is said of bytes that are no tile and no model.

/** Bytes that are not what they are taken for. */
export class DecodeError extends Error {
  override readonly name: string = "DecodeError";
}

/** A tile's bytes end before its levels begin. */
export class HeaderCut extends DecodeError {}
