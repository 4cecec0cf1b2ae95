#include <wayfare/map/detail/copy_on_write_tiles.hpp>

#include <map>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

using Tiles = CopyOnWriteTiles<int>;

int& at(Tiles& tiles, const Cell& c) {
  return tiles.writable(Tiles::tile_of(c))[Tiles::offset_in_tile(c)];
}

TEST(CopyOnWriteTiles, TilesAreContiguousAcrossTheOrigin) {
  EXPECT_EQ(Tiles::tile_of({-1, 0}), (Cell{-1, 0}));
  EXPECT_EQ(Tiles::tile_of({63, 64}), (Cell{0, 1}));
  EXPECT_EQ(Tiles::tile_of({-64, -65}), (Cell{-1, -2}));
  EXPECT_EQ(Tiles::offset_in_tile({0, 0}), 0U);
  EXPECT_EQ(Tiles::offset_in_tile({-1, 0}), 63U);
  EXPECT_EQ(Tiles::offset_in_tile({-64, -1}), 63U * 64U);
}

// Random copies and writes, compared with a std::map that is copied in full.
TEST(CopyOnWriteTiles, CopiesAreIndependentWhateverTheOrderOfWrites) {
  using Model = std::map<Cell, int>;
  Rng rng(5);
  const auto coordinate = [&] {
    return static_cast<int>(rng.below(2000)) * (rng.below(2) == 0 ? 1 : -40);
  };
  std::vector<Tiles> tiles(4, Tiles(-7));
  std::vector<Model> models(4);
  for (int k = 0; k < 3000; ++k) {
    const std::size_t i = rng.below(4), j = rng.below(4);
    if (rng.below(50) == 0) {
      tiles[i] = tiles[j];
      models[i] = models[j];
    }
    const Cell c{coordinate(), coordinate()};
    at(tiles[i], c) = k;
    models[i][c] = k;
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (const Model& any : models) {
      for (const auto& [cell, value] : any) {
        const auto found = models[i].find(cell);
        EXPECT_EQ(tiles[i][cell], found == models[i].end() ? -7 : found->second);
      }
    }
  }
}

TEST(CopyOnWriteTiles, VisitsEveryTileOnceInOrder) {
  Tiles tiles(0);
  std::vector<Cell> made;
  for (int x = 3; x >= -3; --x) {
    for (int y = -3; y <= 3; ++y) {
      tiles.writable({x * 1000, y})[0] = x * 10 + y;
      made.push_back({x * 1000, y});
    }
  }
  std::sort(made.begin(), made.end());
  std::vector<Cell> visited;
  tiles.for_each_tile([&](const Cell& tile, std::span<const int> cells) {
    visited.push_back(tile);
    EXPECT_EQ(cells.size(), 4096U);
    EXPECT_EQ(cells[0], tile.x / 100 + tile.y);
  });
  EXPECT_EQ(visited, made);
  EXPECT_EQ(tiles.tile_count(), made.size());
  EXPECT_EQ(tiles.find({5, 5}), nullptr);
}

// For the thread sanitizer: threads write to their own copies of shared tiles and destroy them
// while others still read.
TEST(CopyOnWriteTiles, CopiesOfOneGridMayBeWrittenFromManyThreads) {
  Tiles shared(0);
  for (int x = 0; x < 640; ++x) at(shared, {x, 0}) = x;
  std::vector<Tiles> copies(4, shared);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 1; round <= 20; ++round) {
        Tiles mine = copies[static_cast<std::size_t>(t)];
        for (int x = 0; x < 640; ++x) at(mine, {x, 0}) += round * (t + 1);
        copies[static_cast<std::size_t>(t)] = mine;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int t = 0; t < 4; ++t)
    for (int x = 0; x < 640; ++x)
      EXPECT_EQ((copies[static_cast<std::size_t>(t)][{x, 0}]), x + 210 * (t + 1));  // Σ 1…20
  EXPECT_EQ((shared[{639, 0}]), 639);
}

}  // namespace
}  // namespace wayfare
