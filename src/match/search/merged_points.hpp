#pragma once

#include <cstddef>
#include <cstdint>

#include <wayfare/match/branch_and_bound.hpp>

#include "map/kernels/kernels.hpp"
#include "match/search/candidates.hpp"

namespace wayfare::detail {

inline constexpr std::size_t kNotMade = static_cast<std::size_t>(-1);
/// Entries kept; beyond, all are forgotten and made again when asked for.
inline constexpr std::size_t kMostMerged = std::size_t{1} << 24;

inline void forget(MergedPoints& m, const CandidateSpace& s) {
  m.parts = (s.points + kernels::kMergedPart - 1) / kernels::kMergedPart;
  m.first.assign(s.headings.size(), kNotMade);
  m.ends.resize(s.headings.size() * static_cast<std::size_t>(m.parts));
  m.used = 0;
}

/// Room for `more` entries, and those that are read past the end.
inline void make_room(MergedPoints& m, std::size_t more) {
  const std::size_t needed = m.used + more + 16;
  if (needed <= m.x.size()) return;
  for (auto* axis : {&m.x, &m.y}) axis->resize(needed + needed / 2);
  m.weight.resize(m.x.size());
}

/// Points placed at a heading, cells of the table.
struct Placed {
  const std::int32_t *u, *v;
};

/// The entries of heading step k in units of the level from the window's corner: groups begin
/// at whole units from there, so that the same entries serve them all. `place` is asked for the
/// points where they have not been made yet.
template <class Place>
kernels::Merged merged(MergedPoints& m, const CandidateSpace& s, int level, int k, Place&& place) {
  const auto heading = static_cast<std::size_t>(k + s.half_k);
  const auto count = static_cast<std::size_t>(s.points);
  if (m.first[heading] == kNotMade) {
    if (m.used + count > kMostMerged) forget(m, s);
    make_room(m, count);
    const Placed at = place(k);
    m.first[heading] = m.used;
    m.used += static_cast<std::size_t>(kernels::best_kernels().merge(
        at.u, at.v, s.points, {-s.half_x, -s.half_y, 2 * level}, m.x.data() + m.used,
        m.y.data() + m.used, m.weight.data() + m.used,
        m.ends.data() + heading * static_cast<std::size_t>(m.parts)));
  }
  const std::size_t first = m.first[heading];
  return {m.x.data() + first, m.y.data() + first, m.weight.data() + first,
          m.ends.data() + heading * static_cast<std::size_t>(m.parts)};
}

}  // namespace wayfare::detail
