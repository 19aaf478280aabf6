/* The functions of FMI 3.0 that these components have no use for: each says so; a part of fmi3_rest.c. */

#define NOT_HERE(name, parameters, ignored, what) \
    fmi3Status fmi3##name parameters              \
    {                                             \
        ignored;                                  \
        return unsupported(instance, what);       \
    }

/* Of types that no variable has nothing may be asked; nothing at all may. */
#define NONE_HERE(name, parameters, ignored, what)                         \
    fmi3Status fmi3##name parameters                                       \
    {                                                                      \
        (void)r, ignored;                                                  \
        return n ? unsupported(instance, what) : status(instance != NULL); \
    }

#define ASKED fmi3Instance instance, const fmi3ValueReference r[], size_t n
#define NO_STRUCTURE WL_NAME " has no structural parameters"
#define DESCRIBED "dependencies are in modelDescription.xml"

NOT_HERE(EnterStepMode, (fmi3Instance instance), (void)0, WL_NAME " has no event mode to leave")
NOT_HERE(EnterConfigurationMode, (fmi3Instance instance), (void)0, NO_STRUCTURE)
NOT_HERE(ExitConfigurationMode, (fmi3Instance instance), (void)0, NO_STRUCTURE)
NOT_HERE(EvaluateDiscreteStates, (fmi3Instance instance), (void)0, WL_NAME " has no event mode")
NOT_HERE(ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 t), ((void)r, (void)t),
         WL_NAME " has no clocks")

#define NO_TYPE(type)                                                                                               \
    NONE_HERE(Get##type, (ASKED, fmi3##type v[], size_t m), ((void)v, (void)m), WL_NAME " has no variables of type " #type)             \
    NONE_HERE(Set##type, (ASKED, const fmi3##type v[], size_t m), ((void)v, (void)m), WL_NAME " has no variables of type " #type)

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(UInt64)
NO_TYPE(String)
NONE_HERE(GetBinary, (ASKED, size_t s[], fmi3Binary v[], size_t m), ((void)s, (void)v, (void)m), WL_NAME " has no variables of type Binary")
NONE_HERE(SetBinary, (ASKED, const size_t s[], const fmi3Binary v[], size_t m), ((void)s, (void)v, (void)m),
          WL_NAME " has no variables of type Binary")

#define NO_CLOCK(name, ignored, ...) NONE_HERE(name, (ASKED, __VA_ARGS__), ignored, WL_NAME " has no clocks")
NO_CLOCK(GetClock, ((void)a), fmi3Clock a[])
NO_CLOCK(SetClock, ((void)a), const fmi3Clock a[])
NO_CLOCK(GetShiftDecimal, ((void)a), fmi3Float64 a[])
NO_CLOCK(SetShiftDecimal, ((void)a), const fmi3Float64 a[])
NO_CLOCK(SetIntervalDecimal, ((void)a), const fmi3Float64 a[])
NO_CLOCK(GetIntervalDecimal, ((void)a, (void)b), fmi3Float64 a[], fmi3IntervalQualifier b[])
NO_CLOCK(GetShiftFraction, ((void)a, (void)b), fmi3UInt64 a[], fmi3UInt64 b[])
NO_CLOCK(SetShiftFraction, ((void)a, (void)b), const fmi3UInt64 a[], const fmi3UInt64 b[])
NO_CLOCK(SetIntervalFraction, ((void)a, (void)b), const fmi3UInt64 a[], const fmi3UInt64 b[])
NO_CLOCK(GetIntervalFraction, ((void)a, (void)b, (void)c), fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier c[])

NOT_HERE(GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n), ((void)r, (void)n), DESCRIBED)
NOT_HERE(GetVariableDependencies,
         (fmi3Instance instance, fmi3ValueReference r, size_t a[], fmi3ValueReference b[], size_t c[],
          fmi3DependencyKind d[], size_t n),
         ((void)r, (void)a, (void)b, (void)c, (void)d, (void)n), DESCRIBED)
NOT_HERE(GetAdjointDerivative,
         (fmi3Instance instance, const fmi3ValueReference u[], size_t un, const fmi3ValueReference k[], size_t kn,
          const fmi3Float64 s[], size_t sn, fmi3Float64 v[], size_t vn),
         ((void)u, (void)un, (void)k, (void)kn, (void)s, (void)sn, (void)v, (void)vn),
         "gives directional derivatives, not adjoint ones")
