#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "capture/recording.h"
#include "chequer/camera_model.h"
#include "chequer/image.h"
#include "setup/camera_setup.h"

namespace chequer {

/// Where a command gets frames from, as typed.
struct FrameFeedOptions {
  std::vector<std::string> inputs;  ///< recordings, folders of images, images
  std::string config;               ///< supplies the camera where there are none, and what else is left out
  std::string one_channel = "Mono8";
  std::optional<double> gamma;
  std::optional<double> seconds;  ///< of a camera
};

/// Adds the inputs, --config, --one-channel, --gamma and --seconds to a command.
/// @param supplies what the command takes from the configuration beside the camera, for the help.
void AddFrameFeedOptions(CLI::App& command, FrameFeedOptions& options, const std::string& supplies);

/// A frame of a feed.
struct FedFrame {
  ImageView image;  ///< valid until the next frame is asked for
  std::string name;
  /// Gives the same image again, later.
  std::function<Image()> reload;
};

/// Goes through frames, one after the other. SIGINT and SIGTERM end it early instead of the program.
class FrameFeed {
 public:
  /// Throws CLI::ValidationError where the options contradict each other or name nothing, std::runtime_error where
  /// nothing can be opened.
  /// @param setup what options.config says; its camera is used where there are no inputs.
  /// @param calibrated whose size a camera is asked for where the configuration leaves it out; may be null.
  FrameFeed(const FrameFeedOptions& options, const std::optional<CameraSetup>& setup, const CameraModel* calibrated);
  ~FrameFeed();
  FrameFeed(const FrameFeed&) = delete;
  FrameFeed& operator=(const FrameFeed&) = delete;

  /// The next frame; nothing at the end, when time is up, or when interrupted. Frames that cannot be read are named on
  /// standard error and passed over. Throws std::runtime_error where the camera goes away.
  std::optional<FedFrame> Next();

  /// Whether it is a camera: somebody moves things in front of it.
  bool is_live() const { return source_ != nullptr; }
  int failed() const { return failed_; }
  /// How many frames there are in all; 0 of a camera, as nobody knows.
  std::size_t total() const { return recording_ ? recording_->frames.size() : 0; }

 private:
  std::optional<FedFrame> NextRecorded();
  std::optional<FedFrame> NextLive();
  bool IsInterrupted() const;

  std::shared_ptr<Recording> recording_;  ///< shared with the reloads of its frames
  std::size_t next_ = 0;
  Image image_;
  std::unique_ptr<FrameSource> source_;
  Frame frame_;
  std::optional<double> seconds_;
  std::optional<std::chrono::steady_clock::time_point> started_;
  std::unique_ptr<sigset_t> old_signals_;
  int failed_ = 0;
};

/// A copy of an image in packed memory.
Image CopyOf(const ImageView& image);

}  // namespace chequer
