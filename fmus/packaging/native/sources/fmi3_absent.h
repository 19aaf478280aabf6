/* The functions of FMI 3.0 that these components have no use for: each says so; a part of fmi3_cs.c. */

#define NOT_HERE(name, parameters, unused, what) \
    fmi3Status name parameters                   \
    {                                            \
        unused;                                  \
        return unsupported(instance, what);      \
    }

/* Of types that no variable has nothing may be asked; nothing at all may. */
#define NONE_HERE(name, parameters, count, unused, what)                       \
    fmi3Status name parameters                                                 \
    {                                                                          \
        unused;                                                                \
        return count ? unsupported(instance, what) : status(instance != NULL); \
    }

NOT_HERE(fmi3EnterStepMode, (fmi3Instance instance), (void)0, WL_NAME " has no event mode to leave")
NOT_HERE(fmi3EnterConfigurationMode, (fmi3Instance instance), (void)0, WL_NAME " has no structural parameters")
NOT_HERE(fmi3ExitConfigurationMode, (fmi3Instance instance), (void)0, WL_NAME " has no structural parameters")
NOT_HERE(fmi3EvaluateDiscreteStates, (fmi3Instance instance), (void)0, WL_NAME " has no event mode")

/* Hosts look for the functions of the other interface types too. */
#define ONLY_COSIMULATION WL_NAME " is for co-simulation alone"
#if !WL_EXCHANGES
NOT_HERE(fmi3EnterEventMode, (fmi3Instance instance), (void)0, WL_NAME " has no event mode")
NOT_HERE(fmi3UpdateDiscreteStates,
         (fmi3Instance instance, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *c, fmi3Boolean *d, fmi3Boolean *e,
          fmi3Float64 *f),
         ((void)a, (void)b, (void)c, (void)d, (void)e, (void)f), WL_NAME " has no event mode")
NOT_HERE(fmi3EnterContinuousTimeMode, (fmi3Instance instance), (void)0, ONLY_COSIMULATION)
NOT_HERE(fmi3CompletedIntegratorStep, (fmi3Instance instance, fmi3Boolean a, fmi3Boolean *b, fmi3Boolean *c),
         ((void)a, (void)b, (void)c), ONLY_COSIMULATION)
NOT_HERE(fmi3SetTime, (fmi3Instance instance, fmi3Float64 t), (void)t, ONLY_COSIMULATION)
NOT_HERE(fmi3SetContinuousStates, (fmi3Instance instance, const fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetContinuousStateDerivatives, (fmi3Instance instance, fmi3Float64 x[], size_t n),
         ((void)x, (void)n), ONLY_COSIMULATION)
NOT_HERE(fmi3GetNominalsOfContinuousStates, (fmi3Instance instance, fmi3Float64 x[], size_t n),
         ((void)x, (void)n), ONLY_COSIMULATION)
NOT_HERE(fmi3GetEventIndicators, (fmi3Instance instance, fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *n), (void)n, ONLY_COSIMULATION)
NOT_HERE(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *n), (void)n, ONLY_COSIMULATION)
#endif
NOT_HERE(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 t),
         ((void)r, (void)t), ONLY_COSIMULATION)

#define ABSENT_TYPE(type)                                                                                        \
    NONE_HERE(fmi3Get##type,                                                                                     \
              (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3##type v[], size_t m), n,      \
              ((void)r, (void)v, (void)m), WL_NAME " has no variables of type " #type)                           \
    NONE_HERE(fmi3Set##type,                                                                                     \
              (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3##type v[], size_t m), n, \
              ((void)r, (void)v, (void)m), WL_NAME " has no variables of type " #type)

ABSENT_TYPE(Float32)
ABSENT_TYPE(Int8)
ABSENT_TYPE(UInt8)
ABSENT_TYPE(Int16)
ABSENT_TYPE(UInt16)
ABSENT_TYPE(UInt32)
ABSENT_TYPE(UInt64)
ABSENT_TYPE(String)

NONE_HERE(fmi3GetBinary,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, size_t s[], fmi3Binary v[], size_t m),
         n, ((void)r, (void)s, (void)v, (void)m), WL_NAME " has no variables of type Binary")
NONE_HERE(fmi3SetBinary,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const size_t s[], const fmi3Binary v[],
          size_t m),
         n, ((void)r, (void)s, (void)v, (void)m), WL_NAME " has no variables of type Binary")
NONE_HERE(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Clock v[]),
         n, ((void)r, (void)v), WL_NAME " has no clocks")
NONE_HERE(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Clock v[]),
         n, ((void)r, (void)v), WL_NAME " has no clocks")
NONE_HERE(fmi3GetIntervalDecimal,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 i[], fmi3IntervalQualifier q[]),
         n, ((void)r, (void)i, (void)q), WL_NAME " has no clocks")
NONE_HERE(fmi3GetIntervalFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64 c[], fmi3UInt64 s[],
          fmi3IntervalQualifier q[]),
         n, ((void)r, (void)c, (void)s, (void)q), WL_NAME " has no clocks")
NONE_HERE(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 s[]),
         n, ((void)r, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3GetShiftFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64 c[], fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetIntervalDecimal,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Float64 i[]),
         n, ((void)r, (void)i), WL_NAME " has no clocks")
NONE_HERE(fmi3SetIntervalFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Float64 s[]),
         n, ((void)r, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetShiftFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NOT_HERE(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n),
         ((void)r, (void)n), "dependencies are in modelDescription.xml")
NOT_HERE(fmi3GetVariableDependencies,
         (fmi3Instance instance, fmi3ValueReference r, size_t a[], fmi3ValueReference b[], size_t c[],
          fmi3DependencyKind d[], size_t n),
         ((void)r, (void)a, (void)b, (void)c, (void)d, (void)n), "dependencies are in modelDescription.xml")

NOT_HERE(fmi3GetAdjointDerivative,
         (fmi3Instance instance, const fmi3ValueReference u[], size_t un, const fmi3ValueReference k[], size_t kn,
          const fmi3Float64 s[], size_t sn, fmi3Float64 v[], size_t vn),
         ((void)u, (void)un, (void)k, (void)kn, (void)s, (void)sn, (void)v, (void)vn),
         "gives directional derivatives, not adjoint ones")
