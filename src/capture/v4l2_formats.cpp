#include "capture/v4l2_formats.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "capture/size_text.h"
#include "core/number_text.h"

namespace chequer {
namespace {

constexpr FourCc kMjpg = MakeFourCc("MJPG");
constexpr FourCc kJpeg = MakeFourCc("JPEG");

struct Known {
  FourCc code;
  PixelFormat format;
};

/// In the order in which they are preferred: without loss before shared chroma.
constexpr std::array<Known, 12> kKnown{{
    {MakeFourCc("RGGB"), PixelFormat::kBayerRg8},
    {MakeFourCc("GBRG"), PixelFormat::kBayerGb8},
    {MakeFourCc("GRBG"), PixelFormat::kBayerGr8},
    {MakeFourCc("BA81"), PixelFormat::kBayerBg8},
    {MakeFourCc("BGR3"), PixelFormat::kBgr8},
    {MakeFourCc("RGB3"), PixelFormat::kRgb8},
    {MakeFourCc("YUYV"), PixelFormat::kYuyv},
    {MakeFourCc("UYVY"), PixelFormat::kUyvy},
    {MakeFourCc("422P"), PixelFormat::kYuv422p},
    {MakeFourCc("NV12"), PixelFormat::kNv12},
    {MakeFourCc("YU12"), PixelFormat::kYuv420p},
    {MakeFourCc("GREY"), PixelFormat::kMono8},
}};

const Known* Find(FourCc code) {
  const auto* known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& k) { return k.code == code; });
  return known == kKnown.end() ? nullptr : known;
}

bool IsUsable(FourCc code) { return IsJpeg(code) || Find(code) != nullptr; }

/// Higher is better.
int Preference(FourCc code) {
  if (code == MakeFourCc("GREY")) return 0;
  if (IsJpeg(code)) return 1;
  return 2 + static_cast<int>(kKnown.end() - Find(code));
}

std::string SizesText(const V4l2SizeOffer& size) {
  std::string text = SizeText(size.min_width, size.min_height);
  if (size.max_width != size.min_width || size.max_height != size.min_height)
    text += " to " + SizeText(size.max_width, size.max_height);
  for (std::size_t i = 0; i < size.rates_hz.size(); ++i)
    text += (i == 0 ? " (" : ", ") + RoundText(size.rates_hz[i], 4);
  return size.rates_hz.empty() ? text : text + " fps)";
}

struct Candidate {
  V4l2FormatChoice choice;
  double rate_hz = 0;  ///< reached, at most the one that is wanted
};

bool IsBetter(const Candidate& a, const Candidate& b) {
  const auto rank = [](const Candidate& c) {
    const bool has_colour = Preference(c.choice.code) > 0;
    return std::tuple(has_colour, c.rate_hz, std::int64_t{c.choice.width} * c.choice.height, Preference(c.choice.code));
  };
  return rank(a) > rank(b);
}

/// The size of an offer that is taken: the one that is wanted, or its largest.
Candidate MakeCandidate(FourCc code, const V4l2SizeOffer& size, const V4l2FormatWish& wish) {
  Candidate candidate;
  candidate.choice.code = code;
  candidate.choice.width = wish.width.value_or(size.max_width);
  candidate.choice.height = wish.height.value_or(size.max_height);
  const double fastest = size.rates_hz.empty() ? wish.fps : size.rates_hz.front();
  candidate.rate_hz = std::min(fastest, wish.fps);
  return candidate;
}

V4l2FormatChoice Wrong(V4l2FormatChoice::Key key, std::string why) {
  V4l2FormatChoice choice;
  choice.wrong = std::move(why);
  choice.wrong_key = key;
  return choice;
}

std::string Names(const std::vector<V4l2FormatOffer>& offers) {
  std::string names;
  for (const V4l2FormatOffer& offer : offers)
    if (IsUsable(offer.code)) names += (names.empty() ? "" : ", ") + NameOfFourCc(offer.code);
  return names;
}

/// Why no offer is the one that is wanted.
V4l2FormatChoice ExplainNoFormat(const std::vector<V4l2FormatOffer>& offers, const V4l2FormatWish& wish) {
  if (wish.pixel_format && !Names(offers).empty())
    return Wrong(V4l2FormatChoice::Key::kPixelFormat,
                 "the camera does not offer " + *wish.pixel_format + "; it offers " + Names(offers));
  std::string codes;
  for (const V4l2FormatOffer& offer : offers) codes += (codes.empty() ? "" : ", ") + FourCcText(offer.code);
  return Wrong(V4l2FormatChoice::Key::kPixelFormat,
               "none of the camera's formats can be used: " + (codes.empty() ? std::string("it has none") : codes));
}

}  // namespace

std::string FourCcText(FourCc code) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>(code >> (8 * i) & 0x7f);
    text += c >= 0x20 && c < 0x7f ? c : '.';
  }
  return text;
}

bool IsJpeg(FourCc code) { return code == kMjpg || code == kJpeg; }

std::optional<PixelFormat> PixelFormatOf(FourCc code) {
  const Known* known = Find(code);
  return known == nullptr ? std::nullopt : std::optional(known->format);
}

std::string NameOfFourCc(FourCc code) {
  if (IsJpeg(code)) return "MJPEG";
  const Known* known = Find(code);
  return known == nullptr ? std::string() : std::string(PixelFormatName(known->format));
}

bool V4l2SizeOffer::Holds(int width, int height) const {
  const auto in = [](int value, int min, int max, int step) {
    return value >= min && value <= max && (step <= 1 || (value - min) % step == 0);
  };
  return in(width, min_width, max_width, step_width) && in(height, min_height, max_height, step_height);
}

V4l2FormatChoice ChooseV4l2Format(const std::vector<V4l2FormatOffer>& offers, const V4l2FormatWish& wish,
                                  int current_width, int current_height) {
  std::optional<Candidate> best;
  std::vector<V4l2FormatOffer> of_format;
  for (const V4l2FormatOffer& offer : offers) {
    if (!IsUsable(offer.code) || (wish.pixel_format && NameOfFourCc(offer.code) != *wish.pixel_format)) continue;
    of_format.push_back(offer);
    std::vector<V4l2SizeOffer> sizes = offer.sizes;
    if (sizes.empty()) {
      const int width = wish.width.value_or(current_width), height = wish.height.value_or(current_height);
      sizes.push_back({width, width, 1, height, height, 1, {}});
    }
    for (const V4l2SizeOffer& size : sizes) {
      if (wish.width && wish.height && !size.Holds(*wish.width, *wish.height)) continue;
      const Candidate candidate = MakeCandidate(offer.code, size, wish);
      if (!best || IsBetter(candidate, *best)) best = candidate;
    }
  }
  if (best) return best->choice;
  if (of_format.empty()) return ExplainNoFormat(offers, wish);
  return Wrong(V4l2FormatChoice::Key::kSize, "the camera does not offer " +
                                                 SizeText(wish.width.value_or(0), wish.height.value_or(0)) +
                                                 "; it offers " + OfferText(of_format));
}

std::string OfferText(const std::vector<V4l2FormatOffer>& offers) {
  std::string text;
  for (const V4l2FormatOffer& offer : offers) {
    if (!IsUsable(offer.code)) continue;
    text += (text.empty() ? "" : "; ") + NameOfFourCc(offer.code);
    for (std::size_t i = 0; i < offer.sizes.size(); ++i) text += (i == 0 ? " " : ", ") + SizesText(offer.sizes[i]);
  }
  return text;
}

}  // namespace chequer
