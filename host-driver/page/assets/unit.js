// Pressures in the unit in which people want to see them. The host speaks kPa.

const unit = {
  name: "kPa", kpa: 1, decimals: 1,

  // "99.8", without the unit.
  number(kpa) {
    const text = (kpa / this.kpa).toFixed(this.decimals);
    return Number(text) === 0 ? text.replace("-", "") : text;
  },

  text(kpa) {
    return this.number(kpa) + " " + this.name;
  },

  // With its sign: a difference.
  signed(kpa) {
    const text = this.number(kpa);
    return text.startsWith("-") ? text.replace("-", "\u2212") : "+" + text;
  },

  // As few digits as a set point needs: 110, 1.5.
  short(kpa) {
    return String(Number((kpa / this.kpa).toFixed(this.decimals)));
  },
};
