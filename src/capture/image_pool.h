#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "chequer/frame.h"
#include "chequer/image.h"

namespace chequer {

/// Copies pixels into an image, which is used again where its size, format and curve are right.
void CopyPixels(const ImageView& from, Image& into);

/// Images that frames bring back when they die, so that decoding into them allocates nothing once it runs. Any thread.
class ImagePool : public std::enable_shared_from_this<ImagePool> {
 public:
  static std::shared_ptr<ImagePool> Make() { return std::shared_ptr<ImagePool>(new ImagePool); }

  /// An image of any size and format, whatever was brought back; an empty one where none was.
  Image Take() {
    const std::lock_guard lock(mutex_);
    if (images_.empty()) return {};
    Image image = std::move(images_.back());
    images_.pop_back();
    return image;
  }

  /// Keeps an image alive for a frame that looks into it, and brings it back. The pool is shared because a frame may
  /// outlive its source.
  std::unique_ptr<FrameLease> Lend(Image image) {
    return std::make_unique<Lease>(shared_from_this(), std::move(image));
  }

 private:
  struct Lease final : FrameLease {
    Lease(std::shared_ptr<ImagePool> from, Image lent) : pool(std::move(from)), image(std::move(lent)) {}
    ~Lease() override { pool->BringBack(std::move(image)); }
    std::shared_ptr<ImagePool> pool;
    Image image;
  };

  ImagePool() = default;

  void BringBack(Image image) {
    constexpr std::size_t kMostKept = 16;  // more are never under way at the same time
    const std::lock_guard lock(mutex_);
    if (images_.size() < kMostKept) images_.push_back(std::move(image));
  }

  std::mutex mutex_;
  std::vector<Image> images_;
};

}  // namespace chequer
