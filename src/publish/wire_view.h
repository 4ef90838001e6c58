#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "publish/view_messages.h"

namespace chequer {

/// The bytes of their LCM types.
std::vector<std::uint8_t> EncodeView(const AskMessage& message);
std::vector<std::uint8_t> EncodeView(const PreviewMessage& message);
std::vector<std::uint8_t> EncodeView(const DetailMessage& message);
std::vector<std::uint8_t> EncodeView(const CameraMessage& message);
std::vector<std::uint8_t> EncodeView(const CalibrationMessage& message);

using ViewMessage = std::variant<AskMessage, PreviewMessage, DetailMessage, CameraMessage, CalibrationMessage>;

/// What bytes from LCM say; nothing where they are none of these types, cut off, or hold what cannot be: a region or a
/// size out of range, numbers that are none.
std::optional<ViewMessage> DecodeViewMessage(std::span<const std::uint8_t> bytes);

/// Whether the bytes begin as one of these types does, sound or not.
bool IsViewMessage(std::span<const std::uint8_t> bytes);

}  // namespace chequer
