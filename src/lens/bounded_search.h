#pragma once

#include <chrono>
#include <functional>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace chequer {

/// What a search finds, if it ends within a time; nothing if it does not. The search runs in a process of its own,
/// which is ended then: OpenCV offers no way to stop one that clutter keeps busy for minutes. What it changes is lost.
std::optional<std::vector<cv::Point2f>> SearchWithin(std::chrono::milliseconds limit,
                                                     const std::function<std::vector<cv::Point2f>()>& search);

}  // namespace chequer
