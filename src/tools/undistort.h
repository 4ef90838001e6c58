#pragma once

#include <memory>

#include "chequer/camera_model.h"
#include "chequer/image.h"

namespace chequer {

/// Makes images look as if a lens without distortion had taken them. One thread.
class Undistorter {
 public:
  explicit Undistorter(const CameraModel& camera);
  ~Undistorter();

  /// The same picture as BGR8, black where the camera did not look. @pre the size is the camera's.
  Image Undistort(const ImageView& image) const;
  /// What holds for it: the same focal length and centre, no distortion.
  const CameraModel& pinhole() const { return pinhole_; }

 private:
  struct Maps;
  CameraModel pinhole_;
  std::unique_ptr<Maps> maps_;
};

}  // namespace chequer
