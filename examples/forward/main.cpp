// The responses of a study from another program: forward_example STUDY
#include <cstdio>
#include <pavement/forward.h>
#include <study/study.h>

int main(int, char** argv) {
    const auto study = explore::study::load_study(argv[1]);
    const pave::pavement::ForwardModel model(study.model);
    const auto answer = model.run(study.model, {}, *model.make_workspace());
    for (std::size_t i = 0; answer && i < study.readings.size(); ++i) {
        std::printf("%.17g\n", study.readings[i].in_unit(answer->values[i]));
    }
    return answer ? 0 : 1;
}
