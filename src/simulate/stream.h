#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "chequer/image.h"
#include "simulate/linear_image.h"
#include "simulate/render.h"
#include "simulate/scenario.h"
#include "simulate/stream_plan.h"
#include "simulate/truth.h"

namespace chequer {

/// The frames of a scenario, each drawn when it is asked for, in any order. Any thread at a time.
class Stream {
 public:
  /// Works out how the robots drive and draws the background. Throws std::runtime_error where the robots find no room,
  /// where a file cannot be read, and with RenderOptions::Check's message.
  explicit Stream(Scenario scenario);
  ~Stream();
  Stream(Stream&&) noexcept;

  std::size_t size() const;
  const Scenario& scenario() const;
  const FramePlan& plan(std::size_t index) const;

  /// What truly is in a frame; its file has no name yet. Boards wholly outside the image are left out.
  FrameTruth Truth(std::size_t index) const;

  /// What Capture makes the frame of: the light on its sensor, and the camera as it is set then, with the frame's
  /// illumination and gain. Whoever wants many frames of one light exposes it himself.
  LinearImage Light(std::size_t index) const;
  RenderOptions CameraOf(std::size_t index) const;

  /// The frame. The same arguments give the same bytes. @param round makes another noise on the same picture.
  Image Draw(std::size_t index, std::uint64_t round = 0) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
