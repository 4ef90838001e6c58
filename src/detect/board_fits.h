#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "detect/board_reading.h"
#include "detect/common/scratch.h"
#include "detect/common/thread_pool.h"
#include "detect/fit_schedule.h"
#include "detect/image_state.h"

namespace chequer {

/// Fits the boards of an image and reads them, while its budget lasts: the first one alone, as it tells what all have
/// in common, the others on all threads. Fills in ImageState::outcomes and ImageState::traits.
class BoardFits {
 public:
  explicit BoardFits(const DetectorOptions& options);

  /// An image begins.
  void Start() { tasks_.Start(); }
  /// Fits the boards from `first` on, but for those that are postponed; plainly where there is a budget: Refine()
  /// follows.
  void FitFrom(const ImageJob& job, std::size_t first);
  /// Fits those boards that were postponed and are not read elsewhere.
  void FitPostponed(const ImageJob& job);
  /// Fits once more, by all that may be in their way, boards for which the plain fit does not do.
  void Refine(const ImageJob& job);

 private:
  /// Of the tasks, does those from `first` on.
  void FitTasks(const ImageJob& job, std::size_t first);
  /// Fits boards until one tells the image's traits. Returns how many were fitted.
  std::size_t FitFirst(const ImageJob& job, std::span<FitTask> tasks);
  /// Fits a board in full that a plain fit has not found, where the budget lasts for it.
  void FitFully(const ImageJob& job, const FitTask& task);
  /// Of tasks in this order, does those that the budget lasts for. Returns how many.
  std::size_t FitInRounds(const ImageJob& job, bool plain_only, std::span<FitTask> tasks);
  void FitOne(const ImageJob& job, const FitOrder& order);
  /// Leaves the tasks to Refine() that are worth it, and what they may take.
  void ChooseForRefining(const ImageJob& job);
  /// Leaves out those from `first` on whose board was read where another was expected.
  void RefuseReadElsewhere(const ImageJob& job, std::size_t first);

  std::vector<BoardReader> readers_;  ///< by thread
  ThreadPool pool_;                   ///< threads, which sleep between images
  Scratch<std::vector<FitTask>> tasks_;
};

}  // namespace chequer
