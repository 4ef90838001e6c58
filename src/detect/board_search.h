#pragma once

#include <cstddef>
#include <vector>

#include "detect/boards/boards.h"
#include "detect/common/scratch.h"
#include "detect/common/search_regions.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"
#include "detect/image_state.h"

namespace chequer {

/// Searches regions of an image for boards: corners, grids, boards by their borders, and a second look at places that
/// show none. Appends to ImageState::boards; a board that a second look shows better takes the place of the one that
/// was found before. Notes what the budget did not last for.
class BoardSearch {
 public:
  explicit BoardSearch(const DetectorOptions& options);

  /// An image begins.
  void Start() { seen_.Start(); }
  void Search(const ImageJob& job, SearchRegion region);

 private:
  void FindGrids(const ImageJob& job, const ImageView& part, const SearchRegion& region);
  /// The largest first, those that waited before them.
  void SortGrids(const Undone& undone);
  /// The corners of a grid.
  PixelBox BoxOf(const Grid& grid) const;
  /// Searches the grids for boards, while the budget's share lasts.
  void AnchorGrids(const ImageJob& job, const SearchRegion& region);
  /// Gathers the points that no board explains. @param before boards that were known before this region.
  void StartSecondLook(const ImageJob& job, std::size_t before);
  /// Takes a second look if the budget lasts for it.
  void LookAgain(const ImageJob& job);
  /// Searches the grids that the second look shows.
  void AnchorView(const ImageJob& job);
  /// A look may show a board that is known: of those from `known` on, keeps the new ones, and those that show more
  /// corners instead of the known ones.
  static void KeepBetter(const ImageJob& job, std::size_t known);

  /// What one image shows, region by region.
  struct Seen {
    Pyramid pyramid;
    std::vector<Corner> corners;
    GridLinker linker;
    Grids grids;
    std::vector<StrongPoint> strong;
    std::vector<PixelBox> found_in;
  };

  Scratch<Seen> seen_;
  BoardFinder finder_;
  SecondLook second_look_;
};

}  // namespace chequer
