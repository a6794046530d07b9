#pragma once

namespace wick {

/// Adds amounts to floats one after the other and hands on what each rounds away to the next, so that the sum of
/// the floats follows the sum of the amounts to the rounding of the last one.
class FloatSum {
 public:
  void set(float& value, double wanted) {
    auto rounded = static_cast<float>(wanted + left_);
    // What others have left makes nothing negative.
    if (wanted >= 0.0 && rounded < 0.0F) rounded = 0.0F;
    left_ += wanted - double(rounded);
    value = rounded;
  }
  void add(float& value, double amount) { set(value, double(value) + amount); }
  /// What no float has taken so far.
  [[nodiscard]] double left() const { return left_; }

 private:
  double left_ = 0.0;
};

}  // namespace wick
