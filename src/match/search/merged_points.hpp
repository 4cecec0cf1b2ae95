#pragma once

#include <cstddef>
#include <cstdint>

#include <wayfare/match/correlative.hpp>

#include "map/kernels/kernels.hpp"
#include "match/search/candidates.hpp"

namespace wayfare::detail {

inline constexpr std::size_t kNotBuilt = static_cast<std::size_t>(-1);
/// Most entries stored; beyond, all are cleared and rebuilt on demand.
inline constexpr std::size_t kMaxMerged = std::size_t{1} << 24;

inline void clear(MergedPoints& m, const CandidateSpace& s) {
  m.parts = (s.points + kernels::kMergedPart - 1) / kernels::kMergedPart;
  m.first.assign(s.headings.size(), kNotBuilt);
  m.ends.resize(s.headings.size() * static_cast<std::size_t>(m.parts));
  m.used = 0;
}

/// Reserves `more` entries, and 16 that may be read past the end.
inline void reserve(MergedPoints& m, std::size_t more) {
  const std::size_t needed = m.used + more + 16;
  if (needed <= m.x.size()) return;
  for (auto* axis : {&m.x, &m.y}) axis->resize(needed + needed / 2);
  m.weight.resize(m.x.size());
}

/// Points transformed at a heading, cells of the table.
struct Placed {
  const std::int32_t *u, *v;
};

/// The entries of heading step k in units of the level from the window's corner. Groups begin at
/// whole units from there, so that they share the entries. `place` gives the points of entries that
/// are not built yet.
template <class Place>
kernels::Merged merged(MergedPoints& m, const CandidateSpace& s, int level, int k, Place&& place) {
  const auto heading = static_cast<std::size_t>(k + s.half_k);
  const auto count = static_cast<std::size_t>(s.points);
  if (m.first[heading] == kNotBuilt) {
    if (m.used + count > kMaxMerged) clear(m, s);
    reserve(m, count);
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
