#pragma once

// An unbounded plane of cells, stored as 64×64 tiles that copies share until one of them writes. A
// particle's map costs only its differences, and a grid grows without moving existing cells.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/detail/reset_on_move.hpp>
#include <wayfare/map/cell.hpp>

namespace wayfare {

/// Different copies may be read and written from different threads; a single object has one writer.
/// A moved-from object has no tiles.
template <class T>
class CopyOnWriteTiles {
 public:
  static constexpr int kBits = 6;                          ///< of a cell's place in its tile
  static constexpr int kSide = 1 << kBits;                 ///< cells along the side of a tile
  using Tile = std::array<T, std::size_t{kSide} * kSide>;  ///< row-major, y grows with the row

  /// Cells without a tile have the value `fill`.
  explicit CopyOnWriteTiles(const T& fill) : fill_(fill) {}

  /// The tile that contains a cell.
  [[nodiscard]] static constexpr Cell tile_of(const Cell& c) {
    return {c.x >> kBits, c.y >> kBits};
  }
  /// Place of a cell in its tile.
  [[nodiscard]] static constexpr std::size_t offset_in_tile(const Cell& c) {
    constexpr int mask = kSide - 1;
    return (static_cast<std::size_t>(c.y & mask) << kBits) | static_cast<std::size_t>(c.x & mask);
  }

  /// Value of a cell.
  [[nodiscard]] const T& operator[](const Cell& c) const {
    const Tile* tile = find(tile_of(c));
    return tile == nullptr ? fill_ : (*tile)[offset_in_tile(c)];
  }

  /// The tile, or null if nothing was written to it.
  [[nodiscard]] const Tile* find(const Cell& tile) const {
    if (slots_.empty()) return nullptr;
    const Slot& slot = slots_[slot_of(tile)];
    return slot.block.get() == nullptr ? nullptr : &slot.block.get()->cells;
  }

  /// The tile for writing: created if missing, copied first if another grid shares it.
  [[nodiscard]] Tile& writable(const Cell& tile) {
    if (count_ * 2 >= slots_.size()) grow();
    Slot& slot = slots_[slot_of(tile)];
    if (slot.block.get() == nullptr) {
      slot = {tile, Handle(new Block)};
      slot.block.get()->cells.fill(fill_);
      ++count_.value;
    } else if (slot.block.shared()) {
      slot.block = Handle(new Block(slot.block.get()->cells));
    }
    return slot.block.get()->cells;
  }

  /// Number of tiles.
  [[nodiscard]] std::size_t tile_count() const { return count_; }

  /// Calls `visit(tile coordinates, cells)` for every tile, in order of (x, y).
  template <class Visit>
  void for_each_tile(Visit&& visit) const {
    std::vector<const Slot*> used;
    used.reserve(count_);
    for (const Slot& s : slots_)
      if (s.block.get() != nullptr) used.push_back(&s);
    std::sort(used.begin(), used.end(),
              [](const Slot* a, const Slot* b) { return a->tile < b->tile; });
    for (const Slot* s : used) visit(s->tile, std::span<const T>(s->block.get()->cells));
  }

 private:
  struct Block {
    Block() = default;
    explicit Block(const Tile& from) : cells(from) {}
    std::atomic<int> owners{1};
    alignas(64) Tile cells;  // vectors of a row then lie in one cache line
  };
  /// Like shared_ptr, but the test for a single owner synchronises with owners that were destroyed.
  class Handle {
   public:
    Handle() = default;
    explicit Handle(Block* block) : block_(block) {}
    Handle(const Handle& o) : block_(o.block_) {
      if (block_ != nullptr) block_->owners.fetch_add(1, std::memory_order_relaxed);
    }
    Handle(Handle&& o) noexcept : block_(std::exchange(o.block_, nullptr)) {}
    Handle& operator=(Handle o) noexcept {
      std::swap(block_, o.block_);
      return *this;
    }
    ~Handle() {
      if (block_ != nullptr && block_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1)
        delete block_;
    }
    [[nodiscard]] Block* get() const { return block_; }
    [[nodiscard]] bool shared() const { return block_->owners.load(std::memory_order_acquire) > 1; }

   private:
    Block* block_ = nullptr;
  };
  struct Slot {
    Cell tile;
    Handle block;
  };

  /// Open addressing with linear probing; the table is at most half full.
  [[nodiscard]] std::size_t slot_of(const Cell& tile) const {
    const std::uint64_t key =
        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(tile.x)) << 32) |
        static_cast<std::uint32_t>(tile.y);
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32) & mask;
    while (slots_[i].block.get() != nullptr && slots_[i].tile != tile) i = (i + 1) & mask;
    return i;
  }
  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(16, slots_.size() * 2));
    std::swap(old, slots_);
    for (Slot& s : old)
      if (s.block.get() != nullptr) slots_[slot_of(s.tile)] = std::move(s);
  }

  T fill_;
  ResetOnMove<std::size_t> count_;
  std::vector<Slot> slots_;
};

}  // namespace wayfare
