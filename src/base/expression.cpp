#include "base/expression.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <muParser.h>
#include <stdexcept>
#include <unordered_map>

namespace pave {
namespace {

bool continues_name(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

std::string variable(std::size_t i) {
    return "_" + std::to_string(i);
}

struct Compiled {
    mu::Parser parser;
    std::vector<double> values; // where the parser reads
};

std::unique_ptr<Compiled> compile(const std::string& plain, std::size_t count) {
    auto compiled = std::make_unique<Compiled>();
    compiled->values.assign(count, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
        compiled->parser.DefineVar(variable(i), &compiled->values[i]);
    }
    compiled->parser.SetExpr(plain);
    return compiled;
}

} // namespace

Expression::Expression(std::string text, const std::vector<std::string>& known) : text_(std::move(text)) {
    constexpr std::size_t longest = 1000;
    if (text_.size() > longest) {
        throw std::invalid_argument("it is longer than 1000 characters");
    }
    if (text_.find_first_of("=?:\"';{}") != std::string::npos) {
        throw std::invalid_argument("it may hold numbers, names, parentheses, + - * / ^ and functions");
    }
    for (std::size_t i = 0; i < text_.size();) {
        const std::string* found = nullptr;
        if (i == 0 || !continues_name(text_[i - 1])) {
            for (const std::string& name : known) {
                const std::size_t end = i + name.size();
                if (text_.compare(i, name.size(), name) == 0 && (end == text_.size() || !continues_name(text_[end])) &&
                    (found == nullptr || name.size() > found->size())) {
                    found = &name;
                }
            }
        }
        if (found == nullptr) {
            plain_ += text_[i++];
            continue;
        }
        auto at = std::find(reads_.begin(), reads_.end(), *found);
        if (at == reads_.end()) {
            at = reads_.insert(at, *found);
        }
        plain_ += variable(static_cast<std::size_t>(at - reads_.begin()));
        i += found->size();
    }
    try {
        const auto compiled = compile(plain_, reads_.size());
        compiled->parser.Eval();
        if (compiled->parser.GetNumResults() != 1) {
            throw std::invalid_argument("it must be one number");
        }
    } catch (const mu::ParserError& error) {
        std::string what = error.GetMsg();
        if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN && !error.GetToken().empty()) {
            // From the place on that the parser met, the whole word.
            std::size_t end = static_cast<std::size_t>(error.GetPos());
            while (end < plain_.size() && continues_name(plain_[end])) {
                ++end;
            }
            const auto begin = static_cast<std::size_t>(error.GetPos());
            what = "\"" + (end > begin ? plain_.substr(begin, end - begin) : error.GetToken()) + "\" is no known name";
        }
        throw std::invalid_argument(what);
    }
}

double Expression::value(const std::vector<double>& values) const {
    thread_local std::unordered_map<std::string, std::unique_ptr<Compiled>> kept;
    constexpr std::size_t most = 256;
    if (kept.size() > most) {
        kept.clear();
    }
    auto& compiled = kept[plain_];
    if (!compiled || compiled->values.size() != values.size()) {
        compiled = compile(plain_, values.size());
    }
    std::copy(values.begin(), values.end(), compiled->values.begin());
    return compiled->parser.Eval();
}

} // namespace pave
