#pragma once
#include <map>
#include <string>

#include "core/state.h"

namespace wick {

/// Double-entry book of one conserved quantity (kg or J). Stocks are what is held now (sheet, smoke on
/// the grid, ash, ...), flows are what has come in (+) or gone out (-) through the scene's boundary
/// since the start (sources, outflow, radiation). The book closes when
///   sum of stocks now = sum of stocks at the start + sum of flows.
class Ledger {
 public:
  /// States how much of the quantity stock `term` holds now.
  void set_stock(const std::string& term, double amount) { stocks_[term] = amount; }
  /// Adds to flow `term` what has just crossed the boundary; into the scene is positive.
  void book_flow(const std::string& term, double amount) { flows_[term] += amount; }
  /// Takes the present stocks as the start of the book; called once, before the first step.
  void open();

  [[nodiscard]] double total_stock() const;
  [[nodiscard]] double total_flow() const;
  /// The largest amount the book has had to carry: max(|opening|, largest |stock|, largest |flow|).
  [[nodiscard]] double largest_amount() const;
  /// |stocks - opening - flows| over that amount. 0 for an empty book.
  [[nodiscard]] double relative_error() const;
  [[nodiscard]] const std::map<std::string, double>& stocks() const { return stocks_; }
  [[nodiscard]] const std::map<std::string, double>& flows() const { return flows_; }

  void visit(StateVisitor& visitor);

 private:
  std::map<std::string, double> stocks_;
  std::map<std::string, double> flows_;
  double opening_ = 0.0;
};

}  // namespace wick
