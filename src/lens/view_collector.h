#pragma once

#include <functional>
#include <string>
#include <vector>

#include "chequer/image.h"
#include "lens/coverage.h"
#include "lens/lens_views.h"

namespace chequer {

/// Why a view was taken or not.
enum class ViewVerdict { kTaken, kNothingSeen, kBlurred, kAlike };

struct ViewCollectorOptions {
  int width = 0;  ///< of the images, pixels
  int height = 0;
  std::size_t max_views = 60;  ///< more cost time and add little
  bool keep_all = false;       ///< take also what looks like a view before, or is blurred
};

/// Chooses views that tell something new of a stream of images.
class ViewCollector {
 public:
  /// Gives the image of a view again.
  using Reload = std::function<Image()>;

  explicit ViewCollector(ViewCollectorOptions options) : options_(options), coverage_(options.width, options.height) {}

  /// Looks at a view; `reload` is called for when it was taken and is to be read again.
  ViewVerdict Offer(LensView view, Reload reload);

  const std::vector<LensView>& views() const { return views_; }
  const std::vector<Reload>& reloads() const { return reloads_; }
  const ViewCollectorOptions& options() const { return options_; }
  const Coverage& coverage() const { return coverage_; }
  std::size_t offered() const { return offered_; }
  /// Views that were left out as alike.
  std::size_t alike() const { return alike_; }
  /// What the views that were taken still lack, as advice; empty where they are enough.
  std::string Lacking() const;
  /// Views that are tilted enough to tell the focal length.
  int tilted() const { return tilted_; }
  bool is_full() const { return views_.size() >= options_.max_views; }

  /// What to do next, for the one who holds the target.
  std::string Hint(ViewVerdict last) const;

 private:
  bool IsBlurred(const LensView& view) const;
  bool IsAlike(const LensView& view) const;

  ViewCollectorOptions options_;
  Coverage coverage_;
  std::vector<LensView> views_;
  std::vector<Reload> reloads_;
  std::size_t offered_ = 0, alike_ = 0;
  int tilted_ = 0;
};

}  // namespace chequer
