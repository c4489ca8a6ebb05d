module noisy_records
  !! Random records of known lines in noise, the Cramér–Rao bounds of their lines from the whole Jacobian, and how often what
  !! is found keeps to them. BEAMWAVE_DRAWS multiplies the number of draws, by hand.
  use bw_constants, only: pi
  use bw_estimated_lines, only: estimated_line, drifting, estimate_lines, harmonic
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp, qp
  use bw_samples, only: samples_type
  use seeded_draws, only: draws_of, normal, start_draws
  implicit none (type, external)
  private
  public :: analysed, draws_of, judge, made, most_of, start_draws, uniform

  real(dp), parameter, public :: confidence = 0.95_dp, false_alarm = 0.01_dp
  real(dp), parameter, public :: sigmas = 3    !! of what chance does to a count or a mean of so many draws

  type, public :: recipe_type
    !! Lines, and how they are sampled. The noise's deviation is that of each sample.
    integer :: samples = 256
    real(dp), allocatable :: frequency(:), decay(:)          !! periods and e-folds per step
    real(dp), allocatable :: amplitude(:, :), phase(:, :)    !! (line, sensor)
    real(dp) :: chirp = 0                                    !! change of all frequencies over the record, about its middle
    real(dp) :: stiffer = 0                                  !! change of all frequencies from the least to the largest amplitude,
                                                             !! whose square it follows; lines decay
    real(dp) :: noise = 0
    real(dp) :: colour = 0                                   !! of an autoregression of first order
    real(dp) :: grain = 0                                    !! samples are rounded to multiples of it; 0: they are not
    real(dp), allocatable :: place(:)                        !! uneven times
  end type recipe_type

  type, public :: tally_type
    integer :: records = 0         !! drawn
    integer :: right = 0           !! with the right number of lines
    integer :: fewer = 0, more = 0
    integer :: lines = 0           !! of those with the right number
    integer :: drifting = 0, harmonic = 0
    real(dp) :: square(2) = 0      !! squared errors of frequency and decay over their bounds
    integer :: held(4) = 0         !! frequency, decay, amplitude and phase inside their intervals
    real(dp) :: worst(2) = 0       !! largest errors of frequency (bins) and decay (over the record)
  end type tally_type

contains

  real(dp) function most_of(part, numbers)
    !! The largest count of what happens to so large a part at most.
    real(dp), intent(in) :: part
    integer, intent(in) :: numbers
    most_of = part*numbers + sigmas*sqrt(part*numbers) + 1
  end function most_of

  real(dp) function uniform()
    call random_number(uniform)
  end function uniform

  function made(recipe) result(samples)
    !! The samples; phases are reduced before they are rounded.
    type(recipe_type), intent(in) :: recipe
    type(samples_type) :: samples
    real(dp) :: time, noise, middle
    real(qp) :: periods
    integer :: n, s, k
    samples%count = recipe%samples
    if (allocated(recipe%place)) samples%place = recipe%place
    allocate (samples%value(recipe%samples, size(recipe%phase, 2)), source=0.0_dp)
    middle = (recipe%samples - 1)/2.0_dp
    do s = 1, size(samples%value, 2)
      noise = normal()*recipe%noise
      do n = 1, recipe%samples
        if (n > 1) noise = recipe%colour*noise + sqrt(1 - recipe%colour**2)*normal()*recipe%noise
        time = n - 1
        if (allocated(recipe%place)) time = recipe%place(n)
        do k = 1, size(recipe%frequency)
          periods = real(recipe%frequency(k), qp)*time + recipe%chirp*((time - middle)**2 - middle**2)/(4*middle)
          if (abs(recipe%stiffer) > 0) periods = periods &
            & + recipe%stiffer*(1 - exp(-2*recipe%decay(k)*time))/(2*recipe%decay(k))
          samples%value(n, s) = samples%value(n, s) + recipe%amplitude(k, s)*exp(-recipe%decay(k)*time) &
            & *cos(real(2*pi*(periods - anint(periods)), dp) + recipe%phase(k, s))
        end do
        samples%value(n, s) = samples%value(n, s) + noise
        if (recipe%grain > 0) samples%value(n, s) = anint(samples%value(n, s)/recipe%grain)*recipe%grain
      end do
    end do
  end function made

  function analysed(samples) result(lines)
    !! What is estimated of a record.
    type(samples_type), intent(in) :: samples
    type(estimated_line), allocatable :: lines(:)
    type(samples_type) :: used
    type(found_lines) :: found
    used = samples
    call estimate_lines(used, confidence, false_alarm, found, lines)
  end function analysed

  subroutine judge(recipe, tally)
    !! Draw a record, and add what is found in it to the tally. Lines of the recipe are in ascending order.
    type(recipe_type), intent(in) :: recipe
    type(tally_type), intent(inout) :: tally
    type(estimated_line), allocatable :: found(:)
    real(dp) :: bound(2, size(recipe%frequency)), error(2), turn
    integer :: k
    found = analysed(made(recipe))
    tally%records = tally%records + 1
    if (size(found) < size(recipe%frequency)) tally%fewer = tally%fewer + 1
    if (size(found) > size(recipe%frequency)) tally%more = tally%more + 1
    if (size(found) /= size(recipe%frequency)) return
    tally%right = tally%right + 1
    if (recipe%noise > 0) bound = bounds_of(recipe)
    if (.not. recipe%noise > 0) bound = 1
    do k = 1, size(found)
      error = abs([found(k)%frequency - recipe%frequency(k), found(k)%decay - recipe%decay(k)])
      turn = atan2(found(k)%amplitude(1)%im, found(k)%amplitude(1)%re) - recipe%phase(k, 1)
      turn = abs(atan2(sin(turn), cos(turn)))
      tally%lines = tally%lines + 1
      tally%square = tally%square + (error/bound(:, k))**2
      tally%worst = max(tally%worst, error*recipe%samples)
      where ([error, abs(abs(found(k)%amplitude(1)) - recipe%amplitude(k, 1)), turn] <= &
        & [found(k)%frequency_error, found(k)%decay_error, 1.96_dp*found(k)%amplitude_bound(1), 1.96_dp*found(k)%phase_bound(1)]) &
        & tally%held = tally%held + 1
      if (iand(found(k)%status, drifting) > 0) tally%drifting = tally%drifting + 1
      if (iand(found(k)%status, harmonic) > 0) tally%harmonic = tally%harmonic + 1
    end do
  end subroutine judge

  function bounds_of(recipe) result(bound)
    !! The bounds of frequencies and decays, (2, line): the inverse of the Fisher matrix of all unknowns of all samples, offset and
    !! slope of each sensor among them. The slopes are whitened as the noise was coloured.
    type(recipe_type), intent(in) :: recipe
    real(dp) :: bound(2, size(recipe%frequency))
    real(dp), allocatable :: slope(:, :), fisher(:, :), length(:)
    integer :: k
    allocate (slope, source=slopes_of(recipe))
    length = norm2(slope, dim=1)
    do k = 1, size(length)
      slope(:, k) = slope(:, k)/length(k)
    end do
    fisher = inverse(matmul(transpose(slope), slope))
    do k = 1, size(bound, 2)
      bound(1, k) = recipe%noise*sqrt(fisher(2*k - 1, 2*k - 1))/length(2*k - 1)
      bound(2, k) = recipe%noise*sqrt(fisher(2*k, 2*k))/length(2*k)
    end do
  end function bounds_of

  function slopes_of(recipe) result(slope)
    !! The slopes of all samples by frequencies, decays, and each sensor's amplitudes, offset and slope.
    type(recipe_type), intent(in) :: recipe
    real(dp), allocatable :: slope(:, :)
    real(dp) :: time, envelope, angle
    integer :: k, n, s, row, column, lines, sensors
    lines = size(recipe%frequency)
    sensors = size(recipe%phase, 2)
    allocate (slope(recipe%samples*sensors, 2*lines + sensors*(2*lines + 2)), source=0.0_dp)
    do s = 1, sensors
      column = 2*lines + (s - 1)*(2*lines + 2)
      do n = 1, recipe%samples
        row = (s - 1)*recipe%samples + n
        time = n - 1
        if (allocated(recipe%place)) time = recipe%place(n)
        do k = 1, lines
          envelope = exp(-recipe%decay(k)*time)
          angle = 2*pi*recipe%frequency(k)*time + recipe%phase(k, s)
          slope(row, 2*k - 1) = -2*pi*time*recipe%amplitude(k, s)*envelope*sin(angle)
          slope(row, 2*k) = -time*recipe%amplitude(k, s)*envelope*cos(angle)
          slope(row, column + 2*k - 1) = envelope*cos(angle)
          slope(row, column + 2*k) = envelope*sin(angle)
        end do
        slope(row, column + 2*lines + 1:column + 2*lines + 2) = [1.0_dp, time/recipe%samples]
      end do
      do n = s*recipe%samples, (s - 1)*recipe%samples + 2, -1
        slope(n, :) = (slope(n, :) - recipe%colour*slope(n - 1, :))/sqrt(1 - recipe%colour**2)
      end do
    end do
  end function slopes_of

  pure function inverse(matrix) result(inverted)
    !! By elimination with pivots.
    real(dp), intent(in) :: matrix(:, :)
    real(dp) :: inverted(size(matrix, 1), size(matrix, 1))
    real(dp) :: both(size(matrix, 1), 2*size(matrix, 1)), row(2*size(matrix, 1))
    integer :: i, j, n, best
    n = size(matrix, 1)
    both = 0
    both(:, :n) = matrix
    do i = 1, n
      both(i, n + i) = 1
    end do
    do i = 1, n
      best = i - 1 + maxloc(abs(both(i:, i)), dim=1)
      row = both(best, :)
      both(best, :) = both(i, :)
      both(i, :) = row/row(i)
      do j = 1, n
        if (j /= i) both(j, :) = both(j, :) - both(j, i)*both(i, :)
      end do
    end do
    inverted = both(:, n + 1:)
  end function inverse

end module noisy_records
