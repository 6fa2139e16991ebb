// How places of an archive are told, and paths between them measured.

/** Degrees; of local ground, those where its plane is laid on the Earth. */
export interface Place {
  readonly longitude: number;
  readonly latitude: number;
}

/** A straight way on the ground. */
export interface Way {
  /** Metres. */
  readonly length: number;
  /** The place so many metres after its beginning. */
  at(metres: number): Place;
}

export interface Coordinates {
  /** Whether the ground is nowhere on the Earth: there is neither a north nor imagery of it. */
  readonly isLocal: boolean;
  /** Names of the two in a table, and how many decimals they have there. */
  readonly columns: readonly [string, string];
  readonly decimals: number;
  /** The two numbers of a place, and the place of two numbers. */
  numbersOf(place: Place): readonly [number, number];
  placeOf(numbers: readonly [number, number]): Place;
  textOf(place: Place): string;
  way(from: Place, to: Place): Way;
  /** Square metres inside a path that is closed from its last corner to its first. */
  area(corners: readonly Place[]): number;
}
